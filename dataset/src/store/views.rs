//! View sets on disk.

use super::check;
use super::error::StoreError;
use super::hashed_file::{make_folder, read_verified, write_hashed};
use super::instance_fields::{INSTANCE_ID, SYMMETRY, parse_symmetry, show_symmetry};
use super::manifest::{Content, Manifest, Provenance, read_manifest, withdraw};
use super::npy::{read_crops, write_crops};
use super::pose_fields::{from_fields, pose_fields};
use super::tables::{CROPS, INSTANCES, VIEW_SIGHTINGS, VIEWS};
use crate::views::InstanceRecord;
use crate::{InstanceId, Sighting, View, ViewSet, Viewpoint};
use nalgebra::Vector3;
use std::collections::BTreeMap;
use std::path::Path;

/// Writes a view set into `folder`, which is made if need be; what it held of a view set is replaced.
pub fn write_views(folder: &Path, set: &ViewSet, provenance: Provenance) -> Result<Manifest, StoreError> {
    check::view_set(set).map_err(StoreError::unfit(folder))?;
    make_folder(folder)?;
    withdraw(folder)?;
    let crops =
        write_hashed(&folder.join(CROPS), |sink| write_crops(sink, set.views.iter().map(|v| &v.crop)))?;
    let instances = write_hashed(&folder.join(INSTANCES.file), |sink| {
        INSTANCES.write(sink, set.instances.iter().enumerate(), |row, (i, instance)| {
            row.put(i)?;
            row.put(instance.id)?;
            row.put(&instance.family)?;
            row.put(show_symmetry(instance.symmetry))
        })
    })?;
    let views = write_hashed(&folder.join(VIEWS.file), |sink| {
        VIEWS.write(sink, &set.views, |row, view| {
            row.put(view.instance)?;
            row.put(view.session)?;
            row.put_floats(&view.viewpoint.direction)?;
            row.put_floats([&view.viewpoint.roll, &view.viewpoint.log_distance, &view.visible_fraction])?;
            row.put_floats(&view.box_center_error)
        })
    })?;
    let files = [(CROPS, crops), (INSTANCES.file, instances), (VIEWS.file, views)];
    let mut files: BTreeMap<_, _> = files.map(|(name, record)| (name.to_owned(), record)).into();
    let sighted = || set.views.iter().enumerate().filter_map(|(i, view)| Some((i, view.sighting.as_ref()?)));
    if sighted().next().is_some() {
        let record = write_hashed(&folder.join(VIEW_SIGHTINGS.file), |sink| {
            VIEW_SIGHTINGS.write(sink, sighted(), |row, (view, sighting)| {
                row.put(view)?;
                row.put(sighting.step)?;
                row.put_floats(&pose_fields(&sighting.session_from_camera))?;
                row.put_floats(&sighting.ray)?;
                row.put_floats([&sighting.angular_size])
            })
        })?;
        files.insert(VIEW_SIGHTINGS.file.to_owned(), record);
    }
    let counts = [("instances", set.instances.len()), ("views", set.views.len())];
    Manifest::new(Content::Views { split: set.split }, counts, files, provenance).commit(folder)
}

/// Reads a view set, bit for bit as it was written.
pub fn read_views(folder: &Path) -> Result<ViewSet, StoreError> {
    let manifest = read_manifest(folder)?;
    let Content::Views { split } = manifest.content else {
        return Err(manifest.not_the_kind(folder, "a view set"));
    };
    let instances = manifest.read_table(folder, &INSTANCES, |row| {
        row.take_index()?;
        Ok(InstanceRecord {
            id: row.take_with(INSTANCE_ID, InstanceId::parse)?,
            family: row.take("a name")?,
            symmetry: row.take_with(SYMMETRY, parse_symmetry)?,
        })
    })?;
    let rows = manifest.read_table(folder, &VIEWS, |row| {
        let (instance, session) = (row.take("an instance")?, row.take("a session")?);
        let direction = Vector3::from(row.take_floats::<3>()?);
        let [roll, log_distance, visible_fraction] = row.take_floats()?;
        let viewpoint = Viewpoint { direction, roll, log_distance };
        Ok((instance, session, viewpoint, visible_fraction, row.take_floats()?))
    })?;
    manifest.check_count(folder, "instances", instances.len())?;
    manifest.check_count(folder, "views", rows.len())?;
    let record = manifest.file(folder, CROPS)?;
    let crops = read_verified(folder, CROPS, record, |source| {
        read_crops(source, folder, CROPS, record.bytes, rows.len())
    })?;
    let mut sightings = vec![None; rows.len()];
    let listed = manifest.read_table_if_listed(folder, &VIEW_SIGHTINGS, |row| {
        let view: usize =
            row.take_with("the number of a view", |text| text.parse().ok().filter(|i| *i < rows.len()))?;
        let step = row.take("a step")?;
        let session_from_camera = from_fields(row.take_floats()?);
        let (ray, [angular_size]) = (row.take_floats()?, row.take_floats()?);
        Ok((view, Sighting { step, session_from_camera, ray, angular_size }))
    })?;
    for (view, sighting) in listed.into_iter().flatten() {
        sightings[view] = Some(sighting);
    }
    let views =
        rows.into_iter()
            .zip(crops)
            .zip(sightings)
            .map(|(((instance, session, viewpoint, visible_fraction, box_center_error), crop), sighting)| {
                View { instance, session, viewpoint, crop, visible_fraction, box_center_error, sighting }
            })
            .collect();
    let set = ViewSet { split, instances, views };
    check::view_set(&set).map_err(StoreError::invalid(folder))?;
    Ok(set)
}
