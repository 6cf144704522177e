#!/usr/bin/env python3
"""Lays out the furniture of Sweet Home 3D as meshes that a scene can name: y up, in centimetres, a folder each.

    sudo apt-get install sweethome3d-furniture
    python3 examples/sweethome3d/prepare.py furniture
    bench look scenes/mine.yaml

A library (`.sh3f`) is a ZIP file of OBJ models with a catalogue that tells their sizes. Each model is turned and scaled to the
size in the catalogue, as Sweet Home 3D does, and gets a `LICENCE.txt` with its author. One larger than 5 m, such as a tree, is
made smaller and named: a model of it. Faces without a material become white, and those without texture coordinates have the
plain colour of their material. A model that cannot be used is left out and named. Needs no package.
"""

import argparse
import re
import sys
import zipfile
from pathlib import Path, PurePosixPath

LIBRARIES = Path("/usr/share/sweethome3d/furniture")
CATALOGUE = "PluginFurnitureCatalog.properties"
# Vantage takes objects from 5 mm to 5 m, and rounding must not exceed that.
SMALLEST, LARGEST = 0.5, 499.0
# A size that differs by a smaller share than this from the catalogue's is taken for it.
ALIKE = 0.005
# Nothing could collide with what is thinner than this share of its length, such as the marks of a parking lot.
FLAT = 1e-3
# No texture is repeated so often.
LARGEST_UV = 1e4
IMAGES = (".png", ".jpg", ".jpeg")
LICENCES = re.compile(r"licen[cs]e", re.IGNORECASE)


class Unusable(Exception):
    """Why a model is left out."""


def catalogue(library):
    """What holds for the whole library, and the models with what it says of each."""
    text = library.read(CATALOGUE).decode("latin-1")
    whole, models = {}, {}
    for line in text.splitlines():
        key, equals, value = line.partition("=")
        if not equals or key.startswith("#"):
            continue
        name, number_sign, number = key.strip().partition("#")
        of = models.setdefault(int(number), {}) if number_sign else whole
        of[name] = value.strip()
    return whole, [models[number] for number in sorted(models)]


def triple(words):
    numbers = [float(word) for word in words[:3]]
    if len(numbers) < 3:
        raise Unusable(f"a line has {len(numbers)} numbers, expected 3")
    return numbers


def turned(rows, vector):
    return [sum(a * b for a, b in zip(row, vector)) for row in rows]


def resized(lines, model):
    """The lines of an OBJ file with vertices and normals turned and scaled to the size in the catalogue, y up."""
    numbers = [float(word) for word in model.get("modelRotation", "1 0 0 0 1 0 0 0 1").split()]
    rows = [numbers[0:3], numbers[3:6], numbers[6:9]]
    points = [turned(rows, triple(line.split()[1:])) for line in lines if line.startswith("v ")]
    if not points:
        raise Unusable("it has no vertex")
    extents = [max(axis) - min(axis) for axis in zip(*points)]
    wanted = [float(model[key]) for key in ("width", "height", "depth")]
    largest = max(wanted)
    if largest < SMALLEST:
        raise Unusable(f"its largest extent is {largest:g} cm, expected at least {SMALLEST:g}")
    if largest > LARGEST:
        print(f"made smaller: {model['id']}, of {largest:g} cm", file=sys.stderr)
        wanted = [extent * LARGEST / largest for extent in wanted]
    if min(wanted) < FLAT * max(wanted):
        raise Unusable(f"it is flat: {min(wanted):g} cm of {max(wanted):g}")
    scale = [a / b if b > 0 else 1.0 for a, b in zip(wanted, extents)]
    fits = max(extents) <= LARGEST and all(abs(factor - 1) < ALIKE for factor in scale)
    if fits and "modelRotation" not in model:
        return lines
    vertices = iter(points)

    def moved(line):
        if line.startswith("v "):
            return "v " + " ".join(f"{x * factor:.7g}" for x, factor in zip(next(vertices), scale))
        if line.startswith("vn "):
            normal = [x / factor for x, factor in zip(turned(rows, triple(line.split()[1:])), scale)]
            length = sum(x * x for x in normal) ** 0.5 or 1.0
            return "vn " + " ".join(f"{x / length:.6g}" for x in normal)
        return line

    return [moved(line) for line in lines]


def materials_of(text, beside):
    """The colour and the texture of each material of an MTL file; a texture that is no image of the library counts as none."""
    materials = {}
    look = {}
    for line in text.splitlines():
        words = line.split(None, 1)
        key, value = words[0] if words else "", words[1].strip() if len(words) > 1 else ""
        if key == "newmtl":
            look = materials.setdefault(value, {})
        elif key == "Kd":
            look[key] = " ".join(f"{x:g}" for x in triple(value.split()))
        elif key == "map_Kd":
            value = PurePosixPath(value.replace("\\", "/")).name
            if value.lower().endswith(IMAGES) and value in beside:
                look[key] = value
    return materials


def mended(lines, materials):
    """The lines of an OBJ file whose faces have texture coordinates where their material, one of `materials`, has a texture.

    Materials that are missing are added.
    """
    uvs = 0
    named = used = None
    for line in lines:
        words = line.split()
        key = words[0] if words else ""
        if key == "usemtl":
            named = line.split(None, 1)[1].strip() if len(words) > 1 else ""
        elif key == "vt":
            uvs += 1
            sane = all(abs(float(word)) <= LARGEST_UV for word in words[1:3])
            yield line if sane else "vt 0 0"
        elif key == "f":
            corners = [word.split("/") for word in words[1:]]
            mapped = all(len(corner) > 1 and corner[1] and 0 < abs(int(corner[1])) <= uvs for corner in corners)
            material = named or "white"
            look = materials.setdefault(material, {})
            if not mapped:
                corners = [[corner[0], "", *corner[2:]] if len(corner) > 2 else corner[:1] for corner in corners]
                if "map_Kd" in look:
                    material += "_plain"
                    materials.setdefault(material, {"Kd": look["Kd"]} if "Kd" in look else {})
            if material != used:
                used = material
                yield f"usemtl {used}"
            yield " ".join(["f", *("/".join(corner) for corner in corners)])
        elif key in ("v", "vn", "o", "g", "s"):
            yield line


def folders_of(library):
    """The names of files in each folder, with their paths."""
    folders = {}
    for path in library.namelist():
        parent, _, name = path.rpartition("/")
        folders.setdefault(parent, {})[name] = path
    return folders


def lay_out(library, whole, model, beside, folder):
    """Writes one model, whose library has the files `beside` it."""
    path = PurePosixPath(model["model"].lstrip("/"))
    if path.suffix.lower() != ".obj" or path.name not in beside:
        raise Unusable(f"`{path}` is no OBJ file of the library")
    lines = [line.rstrip() for line in library.read(str(path)).decode("latin-1").splitlines()]
    lines = resized(lines, model)
    materials = {}
    for line in lines:
        if line.startswith("mtllib "):
            name = line.split(None, 1)[1].strip()
            # One model names a file that is not there, beside another of its own name.
            name = name if name in beside else path.with_suffix(".mtl").name
            if name not in beside:
                raise Unusable(f"its materials `{name}` are not in the library")
            materials |= materials_of(library.read(beside[name]).decode("latin-1"), beside)
    body = list(mended(lines, materials))
    looks = [f"newmtl {name}\n" + "".join(f"{key} {value}\n" for key, value in materials[name].items()) for name in materials]
    folder.mkdir(parents=True, exist_ok=True)
    write(folder / "model.obj", "\n".join(["mtllib model.mtl", *body]))
    write(folder / "model.mtl", "\n".join(looks))
    for texture in {look["map_Kd"] for look in materials.values() if "map_Kd" in look}:
        (folder / texture).write_bytes(library.read(beside[texture]))
    write(folder / "LICENCE.txt", licence(library, whole, model, beside))


def licence(library, whole, model, beside):
    """The licence with the author, and what the model's own folder says of it."""
    names = [name for name in sorted(beside) if name.lower().endswith((".txt", ".html")) and LICENCES.search(name)]
    parts = [
        f"licence: {whole['license']}; {model['name']} by {model.get('creator', whole['provider'])}, from {whole['name']},"
        f" {whole['provider']}; converted"
    ]
    parts += [library.read(beside[name]).decode("utf-8", "replace") for name in names]
    parts.append(library.read("LICENSE.TXT").decode("utf-8", "replace"))
    return "\n\n".join(parts)


def write(path, text):
    path.write_text(text + "\n", encoding="utf-8")


def name_of(model):
    return re.sub(r"[^a-z0-9]+", "_", model["id"].lower()).strip("_")


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n", 1)[0])
    parser.add_argument("out", type=Path, help="folder that gets a folder for each model")
    parser.add_argument(
        "libraries", type=Path, nargs="*", help=f"`.sh3f` files; those of {LIBRARIES} unless named"
    )
    args = parser.parse_args()
    libraries = args.libraries or sorted(LIBRARIES.glob("*.sh3f"))
    if not libraries:
        parser.error(f"no library in {LIBRARIES}: install sweethome3d-furniture, or name `.sh3f` files")
    written = 0
    for path in libraries:
        with zipfile.ZipFile(path) as library:
            whole, models = catalogue(library)
            folders = folders_of(library)
            for model in models:
                folder = args.out / name_of(model)
                try:
                    beside = folders.get(model["model"].lstrip("/").rpartition("/")[0], {})
                    lay_out(library, whole, model, beside, folder)
                    written += 1
                except (Unusable, ValueError, KeyError) as error:
                    print(f"left out: {model.get('id')}: {error}", file=sys.stderr)
    print(f"{written} models in {args.out}")


if __name__ == "__main__":
    main()
