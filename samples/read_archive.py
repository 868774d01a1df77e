#!/usr/bin/env python3
"""Reads .rro archives with nothing but Python's standard library and format/FORMAT.md.

    read_archive.py chair.rro                  prints a summary
    read_archive.py chair.rro --json           prints the sections as flatc would
    read_archive.py chair.rro --area=0,1,0     prints the effective area seen from above, m^2

As a module, read(path) gives a dict from section name to fields. A structure is a named tuple,
a vector of numbers an array, a vector of structures or tables a list. A file that breaks a rule
raises ArchiveError. Of FORMAT.md's "What must hold" this checks the sizes of grid, tables and
trees and that numbers are finite, no more; what else a reader must know, format/verifier.h checks.
"""
import argparse
import array
import collections
import json
import math
import re
import struct
import sys
import zlib

# ---- schemas/rro.fbs

SCALARS = {"bool": "?", "ubyte": "B", "uint": "I", "float": "f", "double": "d", "GridMap": "B"}
ENUMS = {"GridMap": ("Octahedral", "LatLong")}
STRUCTS = {
    "Vec3d": {"x": "double", "y": "double", "z": "double"},
    "Vec3f": {"x": "float", "y": "float", "z": "float"},
    "Triangle": {"a": "uint", "b": "uint", "c": "uint"},
    "Patch": {"first_face": "uint", "face_count": "uint", "material": "uint", "area": "float",
              "reflectance": "Vec3f", "centre": "Vec3f", "normal": "Vec3f", "cone_cosine": "float"},
    "Cluster": {"first_patch": "uint", "patch_count": "uint", "right_child": "uint",
                "area": "float", "radius": "float", "lo": "Vec3f", "hi": "Vec3f",
                "normal": "Vec3f", "cone_cosine": "float"},
    "Volume": {"lo": "Vec3f", "hi": "Vec3f", "first": "uint", "count": "uint",
               "right_child": "uint"},
}
TABLES = {
    "Meta": {"tool_version": "string", "source_name": "string", "source_sha256": "string",
             "options": "string", "grid_map": "GridMap", "grid_size": "uint = 12",
             "image_resolution": "uint", "source_triangles": "uint", "bounds_lo": "Vec3d",
             "bounds_hi": "Vec3d", "area": "double", "closed": "bool", "convex": "bool"},
    "Mesh": {"origin": "Vec3d", "positions": "[Vec3f]", "triangles": "[Triangle]",
             "faces": "[uint]"},
    "Material": {"name": "string", "reflectance": "Vec3d", "exitance": "Vec3d", "textured": "bool"},
    "Materials": {"materials": "[Material]"},
    "Patches": {"patches": "[Patch]"},
    "Clusters": {"clusters": "[Cluster]"},
    "Area": {"clusters": "[uint]", "whole": "[ubyte]", "whole_scale": "[float]",
             "intrinsic": "[ubyte]", "intrinsic_scale": "[float]"},
    "Visibility": {"visibility": "[ubyte]"},
    "Errors": {"directions": "uint", "whole": "[float]", "intrinsic": "[float]",
               "visibility": "[float]"},
    "Hbv": {"volumes": "[Volume]", "triangles": "[uint]"},
    "Source": {"triangles": "[uint]"},
    "Hit": {"volumes": "[uint]", "whole": "[ubyte]", "intrinsic": "[ubyte]"},
    "Atlas": {"centre": "Vec3f", "radius": "float", "grid_size": "uint", "image_size": "uint",
              "coverage": "[ubyte]"},
    "Selflinks": {"steps": "[ubyte]", "exchange": "[float]", "visibility": "[ubyte]",
                  "escape": "[float]", "received": "[float]", "black": "[float]"},
}
RECORDS = {name: collections.namedtuple(name, members) for name, members in STRUCTS.items()}

# ---- format/FORMAT.md

REQUIRED = ("meta", "mesh", "materials", "patches", "clusters", "source")
KNOWN = REQUIRED + ("area", "visibility", "errors", "hbv", "hit", "atlas", "selflinks")
MAGIC, MAJOR = b"RRO\x1a", 1
HEADER, ENTRY = struct.Struct("<4sHHQQIIII"), struct.Struct("<24sIIQQQQ")
CODECS = RAW, ZLIB = 0, 1
MOST_SECTIONS, MOST_BYTES, MOST_LEVELS, MOST_ZLIB_RATIO = 256, 2**31 - 1, 256, 1032

Section = collections.namedtuple("Section", "name codec crc32 offset stored_bytes raw_bytes")


class ArchiveError(Exception):
    """A file that is not a sound archive: where, what was found, and what was expected."""

    def __init__(self, section, field, found, expected):
        super().__init__(section, field, found, expected)
        self.file, self.section, self.field = None, section, field
        self.found, self.expected = found, expected

    def __str__(self):
        return (f"{self.file}: section {self.section or '(none)'}: field {self.field}: "
                f"found {self.found}, expected {self.expected}")


def expect(condition, section, field, found, expected):
    """Refuses the file unless the condition holds."""
    if not condition:
        raise ArchiveError(section, field, found, expected)


def read(path):
    """Reads and checks an archive: a dict from section name to its fields (see Table)."""
    return load(path)[2]


def load(path):
    """Like read(), with what the container says: ((major, minor), [Section], {name: Table})."""
    try:
        with open(path, "rb") as file:
            data = file.read()
        version, directory = read_container(data)
        sections = {section.name: Buffer(section.name, unpack(data, section)).root()
                    for section in directory if section.name in KNOWN and section.codec in CODECS}
        for name in REQUIRED:
            expect(name in sections, name, "name", "no such section", "one of a known codec")
        check_contents(sections)
        return version, directory, sections
    except ArchiveError as error:
        error.file = path
        raise


# ---- container


def read_container(data):
    """Checks header, directory, padding and checksums of a whole file: (version, [Section])."""
    expect(data[:4] == MAGIC, None, "magic", data[:4], MAGIC)
    expect(len(data) >= HEADER.size, None, "header", len(data), f"{HEADER.size} bytes")
    (_, major, minor, archive_bytes, directory_offset, section_count, directory_crc32, _,
     header_crc32) = HEADER.unpack_from(data)
    expect(major == MAJOR, None, "version_major", major, f"{MAJOR}; compile the object anew")
    check_crc32(data[:36], header_crc32, None, "header_crc32")
    expect(archive_bytes == len(data), None, "archive_bytes", archive_bytes, len(data))
    expect(section_count <= MOST_SECTIONS, None, "section_count", section_count, MOST_SECTIONS)
    directory_end = directory_offset + section_count * ENTRY.size
    check_crc32(data[directory_offset:directory_end], directory_crc32, None, "directory_crc32")
    expect(directory_end <= len(data), None, "directory_offset", directory_offset,
           f"at most {len(data) - section_count * ENTRY.size}")
    parts = [(0, HEADER.size, None), (directory_offset, directory_end, "directory")]

    directory = []
    for name, *numbers, _ in ENTRY.iter_unpack(data[directory_offset:directory_end]):
        expect(re.fullmatch(rb"[a-z0-9_]{1,23}\0+", name), None, "name", name,
               "1 to 23 of a-z 0-9 _, padded with zeros")
        section = Section(name.rstrip(b"\0").decode(), *numbers)
        for field in ("stored_bytes", "raw_bytes"):
            found = getattr(section, field)
            expect(found <= MOST_BYTES, section.name, field, found, f"at most {MOST_BYTES}")
        end = section.offset + section.stored_bytes
        check_crc32(data[section.offset:end], section.crc32, section.name, "crc32")
        directory.append(section)
        parts.append((section.offset, end, section.name))
    names = [section.name for section in directory]
    expect(len(set(names)) == len(names), None, "name", names, "no name twice")

    parts.sort(key=lambda part: part[:2])
    for (_, end, _), (begin, _, name) in zip(parts, parts[1:]):
        expect(begin % 64 == 0, name, "offset", begin, "a multiple of 64")
        expect(begin >= end, name, "offset", begin, f"{end} or more, where another part ends")
        expect(not any(data[end:begin]), name, "padding before it", "other bytes", "zeros")
    expect(parts[-1][1] == len(data), parts[-1][2], "end", parts[-1][1], f"{len(data)}, the file's")
    unpacked = sum(section.raw_bytes for section in directory if section.codec != RAW)
    limit = 64 * 2**20 + 16 * len(data)
    expect(unpacked <= limit, None, "sum of raw_bytes, packed", unpacked, f"at most {limit}")
    return (major, minor), directory


def check_crc32(data, stored, section, field):
    """Refuses bytes whose checksum is not the stored one."""
    found = zlib.crc32(data)
    expect(found == stored, section, field, f"{stored:08x}", f"{found:08x}, that of the bytes")


def unpack(data, section):
    """The payload of a section, inflated no further than the directory declares."""
    payload = data[section.offset:section.offset + section.stored_bytes]
    if section.codec == ZLIB:
        most = len(payload) * MOST_ZLIB_RATIO
        expect(section.raw_bytes <= most, section.name, "raw_bytes", section.raw_bytes, most)
        inflater = zlib.decompressobj()
        try:
            payload = inflater.decompress(payload, section.raw_bytes + 1)
        except zlib.error as error:
            raise ArchiveError(section.name, "payload", error, "zlib data") from error
        expect(inflater.eof and not inflater.unused_data, section.name, "payload",
               "another length", f"one zlib stream of {section.raw_bytes} bytes")
    expect(len(payload) == section.raw_bytes, section.name, "raw_bytes", section.raw_bytes,
           f"{len(payload)}, the payload's")
    return payload


# ---- FlatBuffers


class Table(dict):
    """The fields present in a table of the file; an absent one reads as its default."""

    def __init__(self, kind):
        super().__init__()
        self.kind = kind

    def __missing__(self, field):
        kind, _, default = TABLES[self.kind][field].partition(" = ")
        if kind in ENUMS:
            return ENUMS[kind][0]
        if kind in SCALARS:
            return kind != "bool" and int(default or 0)
        if kind in STRUCTS:
            return make_record(kind, iter([0] * len(number_codes(kind))))
        return "" if kind == "string" else []


def number_codes(kind):
    """The numbers in a scalar or structure, as module struct names them: "fff" for Vec3f.

    All numbers of a structure in the schema have one size, so there is no padding in it.
    """
    if kind in SCALARS:
        return SCALARS[kind]
    return "".join(number_codes(member) for member in STRUCTS[kind].values())


def make_record(kind, numbers):
    """Takes a scalar or structure from an iterator over numbers."""
    if kind in SCALARS:
        return next(numbers)
    return RECORDS[kind](*[make_record(member, numbers) for member in STRUCTS[kind].values()])


class Buffer:
    """A section's payload. No offset is trusted, and no content is read twice."""

    def __init__(self, section, data):
        self.section, self.data = section, data
        self.taken = bytearray(len(data))

    def expect(self, condition, field, found, expected):
        """Refuses the file unless the condition holds."""
        expect(condition, self.section, field, found, expected)

    def root(self):
        """The section's table."""
        return self.table(self.section.capitalize(), self.follow(0, "root"), "")

    def take(self, place, size, field):
        """Marks content as read; refuses it beyond the buffer's end and the second time."""
        end = place + size
        self.expect(end <= len(self.data), field, f"end {end}", f"at most {len(self.data)}")
        self.expect(self.taken.find(1, place, end) < 0, field, "another field's content", "its own")
        self.taken[place:end] = b"\1" * size

    def numbers(self, codes, place, field, count=1):
        """Yields `count` tuples of numbers that lie one after the other."""
        end = place + struct.calcsize("<" + codes) * count
        self.expect(place >= 0 and end <= len(self.data), field, f"{place} to {end}",
                    f"0 to {len(self.data)}")
        alignment = max(struct.calcsize(code) for code in codes)
        self.expect(place % alignment == 0, field, f"place {place}", f"multiple of {alignment}")
        for found in struct.iter_unpack("<" + codes, self.data[place:end]):
            self.expect(all(map(math.isfinite, found)), field, found, "finite numbers")
            yield found

    def number(self, code, place, field):
        """The number at a place."""
        return next(self.numbers(code, place, field))[0]

    def follow(self, place, field):
        """Where the offset at a place leads."""
        return place + self.number("I", place, field)

    def table(self, kind, place, path):
        """The table at a place; its fields are called `path` and their name in messages."""
        vtable = place - self.number("i", place, path + "(vtable)")
        (vtable_size,), (table_size,) = self.numbers("H", vtable, path + "(vtable)", 2)
        self.expect(vtable_size >= 4 and vtable_size % 2 == 0, path + "(vtable)",
                    f"{vtable_size} bytes", "an even number from 4")
        slots = [slot for slot, in self.numbers("H", vtable, path + "(vtable)", vtable_size // 2)]
        self.take(place, table_size, path + "(table)")
        table = Table(kind)
        for (name, declaration), offset in zip(TABLES[kind].items(), slots[2:]):
            if offset != 0:
                field_kind = declaration.partition(" = ")[0]
                inline = field_kind in SCALARS or field_kind in STRUCTS
                size = struct.calcsize("<" + number_codes(field_kind)) if inline else 4
                self.expect(4 <= offset <= table_size - size, path + name, f"offset {offset}",
                            f"{size} bytes in the table's {table_size}")
                get = self.inline if inline else self.outline
                table[name] = get(field_kind, place + offset, path + name)
        return table

    def inline(self, kind, place, field):
        """The scalar or structure at a place."""
        value = make_record(kind, iter(next(self.numbers(number_codes(kind), place, field))))
        if kind in ENUMS:
            self.expect(value < len(ENUMS[kind]), field, value, " or ".join(ENUMS[kind]))
            return ENUMS[kind][value]
        return value

    def outline(self, kind, place, field):
        """The string or vector that the offset at a place leads to."""
        place = self.follow(place, field)
        count = self.number("I", place, field)
        begin = place + 4
        if kind == "string":
            self.take(place, 4 + count + 1, field)
            self.expect(self.data[begin + count] == 0, field, "no zero byte after it", "one")
            return self.data[begin:begin + count].decode(errors="replace")
        element = kind.strip("[]")
        if element in TABLES:
            self.take(place, 4 + 4 * count, field)
            return [self.table(element, self.follow(begin + 4 * index, field), f"{field}[{index}].")
                    for index in range(count)]
        codes = number_codes(element)
        self.take(place, 4 + struct.calcsize("<" + codes) * count, field)
        tuples = self.numbers(codes, begin, field, count)
        if element in STRUCTS:
            return [make_record(element, iter(numbers)) for numbers in tuples]
        return array.array(codes, (number for number, in tuples))


# ---- contents


def check_contents(sections):
    """Refuses grids, tables and trees of other sizes than the limits and other sections allow."""
    size = sections["meta"]["grid_size"]
    expect(2 <= size <= 128, "meta", "grid_size", size, "2 to 128")
    triangles = len(sections["mesh"]["triangles"])
    patches, clusters = sections["patches"]["patches"], sections["clusters"]["clusters"]
    expect(len(clusters) == 2 * len(patches) - 1, "clusters", "clusters", len(clusters),
           f"{2 * len(patches) - 1}, as there are {len(patches)} patches")
    check_levels("clusters", "clusters", clusters)
    check_length(sections, "source", "triangles", triangles)
    if "hbv" in sections:
        check_length(sections, "hbv", "triangles", triangles)
        check_levels("hbv", "volumes", sections["hbv"]["volumes"])
    if "hit" in sections:
        lines = size**2 // 2 if size % 2 == 0 else size**2
        check_length(sections, "hit", "whole", len(sections["hit"]["volumes"]) * lines)
    if "atlas" in sections:
        atlas = sections["atlas"]
        check_length(sections, "atlas", "coverage", atlas["grid_size"]**2 // 2 * atlas["image_size"]**2)
    if "selflinks" in sections:
        links = sections["selflinks"]["steps"].count(1)
        for name in ("exchange", "visibility"):
            check_length(sections, "selflinks", name, links)
    if "visibility" in sections:
        check_length(sections, "visibility", "visibility", len(patches) * size**2)
    if "area" in sections:
        area = sections["area"]
        tables = len(area["clusters"])
        for name in ("whole", "intrinsic"):
            if area[name] or area[name + "_scale"]:
                check_length(sections, "area", name, tables * size**2)
                check_length(sections, "area", name + "_scale", tables)
        for name, values in sections.get("errors", {}).items():
            if name != "directions" and values:
                check_length(sections, "errors", name, tables)


def check_length(sections, section, field, length):
    """Refuses a vector of another length."""
    found = len(sections[section][field])
    expect(found == length, section, field, f"{found} elements", length)


def check_levels(section, field, nodes):
    """Refuses nodes that are no binary tree in preorder, or one of too many levels.

    A subtree is a range of nodes: the root, the left child's range, the right child's.
    """
    pending = [(0, len(nodes), 1)]
    while pending:
        index, end, level = pending.pop()
        place = f"{field}[{index}]"
        expect(index < end, section, place, "no node", "one")
        expect(level <= MOST_LEVELS, section, place, f"level {level}", f"at most {MOST_LEVELS}")
        right = nodes[index].right_child
        if end > index + 1:
            expect(index + 1 < right < end, section, place + ".right_child", right,
                   f"{index + 2} to {end - 1}")
            pending += [(right, end, level + 1), (index + 1, right, level + 1)]
        else:
            expect(right == 0, section, place + ".right_child", right, "0, as it is a leaf")


# ---- directions


def grid_position(grid_map, size, direction):
    """Where a direction lies in the grid: (column, row), whole numbers at the nodes."""
    x, y, z = direction
    if grid_map == "LatLong":
        longitude, latitude = math.atan2(z, x), math.atan2(y, math.hypot(x, z))
        return size * longitude / (2 * math.pi) - 0.5, size * (latitude / math.pi + 0.5) - 0.5
    length = abs(x) + abs(y) + abs(z)
    u, v = x / length, z / length
    if y < 0:
        u, v = math.copysign(1 - abs(v), u), math.copysign(1 - abs(u), v)
    return size * (u + 1) / 2 - 0.5, size * (v + 1) / 2 - 0.5


def row_value(grid_map, size, values, column, row):
    """The value at a column, whole or not, of a row that may be one before or after the grid."""
    if not 0 <= row < size:
        row = min(max(row, 0), size - 1)
        column = column + size / 2 if grid_map == "LatLong" else size - 1 - column
    left = math.floor(column)
    ends = []
    for node_column in (left, left + 1):
        if grid_map == "LatLong" or 0 <= node_column < size:
            ends.append(values[row * size + node_column % size])
        else:
            ends.append(values[(size - 1 - row) * size + min(max(node_column, 0), size - 1)])
    return ends[0] + (column - left) * (ends[1] - ends[0])


def effective_area(archive, direction, table="whole", cluster=0):
    """The area in m^2 of a cluster seen from a direction, or None if the archive has no table.

    The direction points from the object to the observer and need not be normalised. The table
    is "whole" (occluded by the whole object) or "intrinsic" (by the cluster alone).
    """
    meta, area = archive["meta"], archive.get("area")
    if not area or not area[table] or cluster not in area["clusters"]:
        return None
    grid_map, size = meta["grid_map"], meta["grid_size"]
    number = area["clusters"].index(cluster)
    values = area[table][number * size**2:(number + 1) * size**2]
    column, row = grid_position(grid_map, size, direction)
    low = math.floor(row)
    before = row_value(grid_map, size, values, column, low)
    after = row_value(grid_map, size, values, column, low + 1)
    return (before + (row - low) * (after - before)) * area[table + "_scale"][number] / 255


# ---- program


def plain(value):
    """Turns what read() gives into what module json prints as flatc does."""
    if isinstance(value, dict):
        return {name: plain(field) for name, field in value.items()}
    if hasattr(value, "_asdict"):
        return plain(value._asdict())
    return [plain(item) for item in value] if isinstance(value, (list, array.array)) else value


def print_summary(path, version, directory, archive):
    """Prints what is in the archive."""
    meta, mesh = archive["meta"], archive["mesh"]
    print(f"{path}: version {version[0]}.{version[1]}, by rro-compile {meta['tool_version']}")
    print(f"source: {meta['source_name']}, sha256 {meta['source_sha256']}")
    print(f"object: {len(mesh['positions'])} vertices, {len(mesh['triangles'])} triangles, "
          f"{len(mesh['faces'])} faces of {meta['area']:g} m^2, "
          f"{len(archive['patches']['patches'])} patches, "
          f"{len(archive['clusters']['clusters'])} clusters, "
          f"{meta['grid_size']} x {meta['grid_size']} directions ({meta['grid_map']})")
    for material in archive["materials"]["materials"]:
        print("material {name}: reflectance ({:g}, {:g}, {:g}), exitance ({:g}, {:g}, {:g}) W/m^2"
              .format(*material["reflectance"], *material["exitance"], name=material["name"]))
    for section in directory:
        print(f"section {section.name}: {section.stored_bytes} bytes, {section.raw_bytes} unpacked"
              + ("" if section.name in archive else ", unknown"))


def parse_direction(text):
    """Reads X,Y,Z."""
    direction = tuple(float(number) for number in text.split(","))
    if len(direction) != 3 or not all(map(math.isfinite, direction)) or not any(direction):
        raise ValueError(text)
    return direction


def main():
    """Runs the program; 0, or 3 for a file that cannot be read."""
    parser = argparse.ArgumentParser(description="Reads a compiled object.")
    parser.add_argument("file", metavar="FILE.rro")
    parser.add_argument("--json", action="store_true", help="print the sections as JSON")
    parser.add_argument("--area", metavar="X,Y,Z", type=parse_direction,
                        help="print the effective area in m^2 seen from this direction "
                        "(write --area=-1,0,0 where X is negative)")
    options = parser.parse_args()
    try:
        version, directory, archive = load(options.file)
    except (ArchiveError, OSError) as error:
        print(error, file=sys.stderr)
        return 3
    if options.json:
        lines = (f'"{name}": {json.dumps(plain(fields))}' for name, fields in archive.items())
        print("{\n" + ",\n".join(lines) + "\n}")
    elif options.area:
        for table in ("whole", "intrinsic"):
            area = effective_area(archive, options.area, table)
            print(f"{table}: " + ("not in the archive" if area is None else f"{area:.9g} m^2"))
    else:
        print_summary(options.file, version, directory, archive)
    return 0


if __name__ == "__main__":
    sys.exit(main())
