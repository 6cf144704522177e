"""Renders the exported benchmark scene with other simulators; see peers.sh.

peers.py compare SCENE ROUNDS RENDER_RATE...   interleaved rounds, then a table of medians and paired ratios
peers.py mujoco|pybullet SCENE              one line a kind of picture: renderer, kind, pictures per core-second and second
peers.py look SCENE                         mujoco.png and pybullet.png, to compare with ours.png
"""

import json
import os
import statistics
import subprocess
import sys
import time
from pathlib import Path

os.environ.setdefault("MUJOCO_GL", "egl")

import numpy as np

SECONDS = 1.5
NEAR, FAR = 0.01, 20.0


def load(folder):
    scene = json.loads((folder / "scene.json").read_text())
    scene["folder"] = folder
    return scene


def rate(name, work):
    """Repeats work, which returns how many pictures it made, for SECONDS of CPU time."""
    work()
    cpu, wall = time.process_time(), time.perf_counter()
    pictures = 0
    while time.process_time() - cpu < SECONDS:
        pictures += work()
    cpu, wall = time.process_time() - cpu, time.perf_counter() - wall
    print(f"{name} {pictures / cpu:.1f} {pictures / wall:.1f}", flush=True)


def frustum(scene, center, width, height):
    """Left, right, bottom and top, at distance 1, of a part of a shot."""
    fx, fy, cx, cy = (scene[key] for key in ("fx", "fy", "cx", "cy"))
    return (
        (center[0] - width / 2 - cx) / fx,
        (center[0] + width / 2 - cx) / fx,
        (cy - center[1] - height / 2) / fy,
        (cy - center[1] + height / 2) / fy,
    )


def whole(scene):
    width, height = scene["width"], scene["height"]
    return frustum(scene, (width / 2, height / 2), width, height)


class MuJoCo:
    """Shadows, reflections, skybox and MSAA are off, as ours are."""

    COLUMNS = 16

    def __init__(self, scene):
        import mujoco

        self.mujoco, self.scene = mujoco, scene
        self.atlas_side = self.COLUMNS * scene["tile_side"]
        self.model = mujoco.MjModel.from_xml_string(self.xml())
        data = mujoco.MjData(self.model)
        mujoco.mj_forward(self.model, data)
        size = max(scene["width"], self.atlas_side), max(scene["height"], self.atlas_side)
        self.gl = mujoco.GLContext(*size)
        self.gl.make_current()
        self.context = mujoco.MjrContext(self.model, mujoco.mjtFontScale.mjFONTSCALE_100)
        mujoco.mjr_setBuffer(mujoco.mjtFramebuffer.mjFB_OFFSCREEN, self.context)
        self.data, self.option, self.camera = data, mujoco.MjvOption(), mujoco.MjvCamera()
        self.option.geomgroup[:] = [1, 0, 0, 0, 0, 0]
        self.drawn = mujoco.MjvScene(self.model, maxgeom=len(scene["placements"]) + 8)
        self.update()
        for flag in ("SHADOW", "REFLECTION", "SKYBOX", "FOG", "HAZE"):
            self.drawn.flags[getattr(mujoco.mjtRndFlag, f"mjRND_{flag}")] = 0

    def xml(self):
        scene = self.scene
        folder = scene["folder"].resolve()
        assets, geoms = [], []
        for i, placement in enumerate(scene["placements"]):
            assets.append(f'<mesh name="{i}" file="{folder}/{i}.obj" inertia="shell"/>')
            assets.append(f'<texture name="{i}" type="2d" file="{folder}/{i}.png"/>')
            assets.append(f'<material name="{i}" texture="{i}" specular="0" reflectance="0"/>')
            position = " ".join(map(str, placement["position"]))
            quaternion = " ".join(map(str, placement["quaternion_wxyz"]))
            geoms.append(
                f'<geom type="mesh" mesh="{i}" material="{i}" pos="{position}" quat="{quaternion}" contype="0" conaffinity="0"/>'
            )
        light = scene["light"]
        down = " ".join(str(-x) for x in light["towards"])
        ambient, diffuse = (" ".join(map(str, light[key])) for key in ("ambient", "diffuse"))
        offscreen = max(scene["width"], scene["height"], self.atlas_side)
        return f"""<mujoco><statistic extent="1" center="0 0 0"/><visual><quality shadowsize="0" offsamples="0"/>
            <headlight active="0"/><global offwidth="{offscreen}" offheight="{offscreen}"/></visual>
            <asset>{"".join(assets)}</asset><worldbody>
            <light type="directional" castshadow="false" dir="{down}" ambient="{ambient}" diffuse="{diffuse}" specular="0 0 0"/>
            {"".join(geoms)}</worldbody></mujoco>"""

    def update(self):
        everything = self.mujoco.mjtCatBit.mjCAT_ALL
        self.mujoco.mjv_updateScene(
            self.model, self.data, self.option, None, self.camera, everything, self.drawn
        )

    def aim(self, shot, sides):
        left, right, bottom, top = (NEAR * side for side in sides)
        for camera in self.drawn.camera:
            camera.pos[:], camera.forward[:], camera.up[:] = shot["position"], shot["forward"], shot["up"]
            camera.frustum_center, camera.frustum_width = (left + right) / 2, 0.0
            camera.frustum_bottom, camera.frustum_top = bottom, top
            camera.frustum_near, camera.frustum_far = NEAR, FAR
            camera.orthographic = 0

    def segment(self, on):
        flags = self.mujoco.mjtRndFlag
        self.drawn.flags[flags.mjRND_SEGMENT] = self.drawn.flags[flags.mjRND_IDCOLOR] = on

    def picture(self, rect, buffers):
        """Colour, depth if there is a buffer for it, and segmentation."""
        rgb, depth, segmentation = buffers
        for on, pixels, depths in ((0, rgb, depth), (1, segmentation, None)):
            self.segment(on)
            self.mujoco.mjr_render(rect, self.drawn, self.context)
            self.mujoco.mjr_readPixels(pixels, depths, rect, self.context)

    def frames(self, with_depth):
        width, height = self.scene["width"], self.scene["height"]
        rect = self.mujoco.MjrRect(0, 0, width, height)
        buffers = buffers_of(height, width, with_depth)
        sides = whole(self.scene)

        def work():
            for shot in self.scene["shots"]:
                self.aim(shot, sides)
                self.picture(rect, buffers)
            return len(self.scene["shots"])

        return work

    def aim_at(self, window, cull):
        if cull:
            self.model.geom_group[:] = window["hidden"]
            self.update()
        self.aim(self.scene["shots"][window["shot"]], window["sides"])

    def crops(self, cull):
        """Crops one by one."""
        side = self.scene["tile_side"]
        rect = self.mujoco.MjrRect(0, 0, side, side)
        buffers = buffers_of(side, side, False)

        def work():
            for window in self.scene["windows"]:
                self.aim_at(window, cull)
                self.picture(rect, buffers)
            return len(self.scene["windows"])

        return work

    def atlases(self, cull):
        """Crops side by side in a picture that is read as a whole."""
        side, columns = self.scene["tile_side"], self.COLUMNS
        rects = [
            self.mujoco.MjrRect(i % columns * side, i // columns * side, side, side)
            for i in range(columns * columns)
        ]
        full = self.mujoco.MjrRect(0, 0, columns * side, columns * side)
        rgb, _, segmentation = buffers_of(columns * side, columns * side, False)

        def work():
            windows = self.scene["windows"]
            for start in range(0, len(windows), len(rects)):
                for on, pixels in ((0, rgb), (1, segmentation)):
                    self.segment(on)
                    for window, rect in zip(windows[start : start + len(rects)], rects):
                        self.aim_at(window, cull)
                        self.mujoco.mjr_render(rect, self.drawn, self.context)
                    self.mujoco.mjr_readPixels(pixels, None, full, self.context)
            return len(windows)

        return work, rgb

    def measure(self):
        rate("mujoco frames", self.frames(True))
        rate("mujoco frames-without-depth", self.frames(False))
        rate("mujoco crops-32x32", self.crops(False))
        rate("mujoco crops-32x32-culled", self.crops(True))
        rate("mujoco crops-atlas-culled", self.atlases(True)[0])

    def look(self, folder):
        from PIL import Image

        width, height = self.scene["width"], self.scene["height"]
        buffers = rgb, _, segmentation = buffers_of(height, width, False)
        self.aim(self.scene["shots"][0], whole(self.scene))
        self.picture(self.mujoco.MjrRect(0, 0, width, height), buffers)
        colours = np.where(segmentation == 255, 0, segmentation.astype(int) * 37 % 256).astype(np.uint8)
        Image.fromarray(np.vstack([rgb[::-1], colours[::-1]])).save(folder / "mujoco.png")
        work, rgb = self.atlases(True)
        self.scene["windows"] = self.scene["windows"][: self.COLUMNS**2]
        work()
        Image.fromarray(np.ascontiguousarray(rgb[::-1])).save(folder / "mujoco-atlas.png")


def buffers_of(height, width, with_depth):
    rgb, segmentation = (np.zeros((height, width, 3), np.uint8) for _ in range(2))
    return rgb, np.zeros((height, width), np.float32) if with_depth else None, segmentation


class PyBullet:
    """The CPU renderer, without shadows."""

    def __init__(self, scene):
        import pybullet

        self.pybullet, self.scene = pybullet, scene
        assert pybullet.isNumpyEnabled(), "PyBullet was built without NumPy: pictures would be copied number by number"
        pybullet.connect(pybullet.DIRECT)
        for i, placement in enumerate(scene["placements"]):
            shape = pybullet.createVisualShape(
                pybullet.GEOM_MESH, fileName=str(scene["folder"] / f"{i}.obj"), rgbaColor=[1, 1, 1, 1]
            )
            w, x, y, z = placement["quaternion_wxyz"]
            body = pybullet.createMultiBody(
                0, baseVisualShapeIndex=shape, basePosition=placement["position"], baseOrientation=[x, y, z, w]
            )
            texture = pybullet.loadTexture(str(scene["folder"] / f"{i}.png"))
            pybullet.changeVisualShape(body, -1, textureUniqueId=texture)

    def picture(self, shot, sides, width, height):
        target = [p + f for p, f in zip(shot["position"], shot["forward"])]
        view = self.pybullet.computeViewMatrix(shot["position"], target, shot["up"])
        left, right, bottom, top = (NEAR * side for side in sides)
        projection = self.pybullet.computeProjectionMatrix(left, right, bottom, top, NEAR, FAR)
        light = self.scene["light"]
        return self.pybullet.getCameraImage(
            width,
            height,
            view,
            projection,
            lightDirection=light["towards"],
            lightColor=[1, 1, 1],
            lightDistance=10,
            shadow=0,
            lightAmbientCoeff=light["ambient"][0],
            lightDiffuseCoeff=light["diffuse"][0],
            lightSpecularCoeff=0,
            renderer=self.pybullet.ER_TINY_RENDERER,
        )

    def frame(self, shot):
        return self.picture(shot, whole(self.scene), self.scene["width"], self.scene["height"])

    def measure(self):
        side = self.scene["tile_side"]

        def frames():
            for shot in self.scene["shots"]:
                self.frame(shot)
            return len(self.scene["shots"])

        def crops():
            for window in self.scene["windows"]:
                self.picture(self.scene["shots"][window["shot"]], window["sides"], side, side)
            return len(self.scene["windows"])

        rate("pybullet frames", frames)
        rate("pybullet crops-32x32", crops)

    def look(self, folder):
        from PIL import Image

        width, height, rgb, _, segmentation = self.frame(self.scene["shots"][0])
        rgb = np.reshape(rgb, (height, width, 4))[..., :3].astype(np.uint8)
        ids = np.repeat(np.reshape(segmentation, (height, width, 1)) * 37 % 256, 3, axis=2).astype(np.uint8)
        Image.fromarray(np.vstack([rgb, ids])).save(folder / "pybullet.png")


def prepare_windows(scene):
    """What a window's frustum is, and which placements' bounding spheres lie outside of it."""
    spheres = []
    for i, placement in enumerate(scene["placements"]):
        lines = (scene["folder"] / f"{i}.obj").read_text().splitlines()
        vertices = np.array([line.split()[1:] for line in lines if line.startswith("v ")], float)
        w, x, y, z = placement["quaternion_wxyz"]
        axis = np.array([x, y, z])
        turned = vertices + 2 * np.cross(axis, np.cross(axis, vertices) + w * vertices)
        middle = (turned.min(0) + turned.max(0)) / 2
        spheres.append((middle + placement["position"], np.linalg.norm(turned - middle, axis=1).max()))
    for window in scene["windows"]:
        shot = scene["shots"][window["shot"]]
        left, right, bottom, top = frustum(scene, window["center"], window["side"], window["side"])
        window["sides"] = left, right, bottom, top
        forward, up = np.array(shot["forward"]), np.array(shot["up"])
        rightwards = np.cross(forward, up)
        planes = [rightwards - left * forward, right * forward - rightwards, up - bottom * forward, top * forward - up]
        window["hidden"] = [
            int(any(plane @ (center - shot["position"]) < -radius * np.linalg.norm(plane) for plane in planes))
            for center, radius in spheres
        ]


def compare(scene, folder, rounds, ours):
    here = [sys.executable, __file__]
    commands = [ours, here + ["mujoco", folder], here + ["pybullet", folder]]
    rates = {}
    for number in range(rounds):
        print(f"round {number + 1} of {rounds}", file=sys.stderr)
        for command in commands:
            lines = subprocess.run(command, check=True, stdout=subprocess.PIPE, text=True).stdout
            for line in lines.splitlines():
                renderer, kind, per_core, _ = line.split()
                rates.setdefault((renderer, kind), []).append(float(per_core))

    visible = len(scene["windows"]) / len(scene["shots"])
    others = sum(len(set(window["seen"]) - {0, window["target"]}) for window in scene["windows"])
    drawn = sum(window["hidden"].count(0) for window in scene["windows"]) / len(scene["windows"])
    triangles = [placement["triangles"] for placement in scene["placements"]]
    print(
        f"{len(triangles)} placements of {sum(triangles)} triangles in all, {visible:.1f} objects visible a frame; "
        f"{others / len(scene['windows']):.2f} others visible a tile, {drawn:.2f} placements in its frustum.\n"
    )
    rates["mujoco", "crops-of-frames"] = [visible * r for r in rates["mujoco", "frames-without-depth"]]
    rates["pybullet", "crops-of-frames"] = [visible * r for r in rates["pybullet", "frames"]]
    print("| renderer | pictures | per core-second [min..max] |\n|---|---|---|")
    for (renderer, kind), values in sorted(rates.items()):
        print(f"| {renderer} | {kind} | {spread(values, 0)} |")

    print("\n| pictures | ours / peer's | paired ratio [min..max] |\n|---|---|---|")
    for ours, pictures in (("wgpu", "frames"), ("reference", "frames"), ("wgpu", "crops"), ("reference", "crops")):
        for (peer, kind), values in rates.items():
            if peer in ("mujoco", "pybullet") and (kind == pictures or pictures == "crops" and "crops" in kind):
                pairs = [a / b for a, b in zip(rates.get((ours, pictures), []), values)]
                if pairs:
                    print(f"| {pictures} | {ours} / {peer} {kind} | {spread(pairs, 2)} |")


def spread(values, digits):
    median, low, high = statistics.median(values), min(values), max(values)
    return f"{median:.{digits}f} [{low:.{digits}f}..{high:.{digits}f}]"


def main():
    command, folder, *rest = sys.argv[1:]
    scene = load(Path(folder))
    prepare_windows(scene)
    peers = {"mujoco": MuJoCo, "pybullet": PyBullet}
    if command == "compare":
        compare(scene, folder, int(rest[0]), rest[1:])
    elif command == "look":
        for peer in peers.values():
            peer(scene).look(Path(folder))
    else:
        peers[command](scene).measure()


if __name__ == "__main__":
    main()
