//! JPEG files as bytes.

/// Markers, which do not occur in the data of a scan.
const START_OF_SCAN: &[u8] = &[0xff, 0xda];
const END_OF_IMAGE: &[u8] = &[0xff, 0xd9];

/// Whether the last scan is followed by the end of the image: a decoder itself makes up what a file that is cut short lacks.
pub fn is_whole(jpeg: &[u8]) -> bool {
    let mut markers = jpeg.windows(2).rev();
    markers.find(|two| [START_OF_SCAN, END_OF_IMAGE].contains(two)).is_some_and(|last| last == END_OF_IMAGE)
}
