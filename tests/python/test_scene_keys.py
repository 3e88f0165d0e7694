"""The tables of the scene's keys: what the JSON schema says of each key, the reader says too, and tests/data/every_key.yaml has all."""
import copy
import json
import re
from random import Random

import jsonschema
import pytest
import yaml

import unibody
from conftest import PROGRAM, SOURCE, mpirun

DATA = SOURCE / "tests" / "data"


class Loader(yaml.SafeLoader):  # pylint: disable=too-many-ancestors
    """YAML 1.2, as the program reads it: `on` is a text."""


Loader.yaml_implicit_resolvers = {
    first: [(tag, pattern) for tag, pattern in resolvers if tag != "tag:yaml.org,2002:bool"]
    for first, resolvers in yaml.SafeLoader.yaml_implicit_resolvers.items()}
Loader.add_implicit_resolver("tag:yaml.org,2002:bool", re.compile(r"^(?:true|false)$"), list("tf"))

EXAMPLES = list(yaml.load_all((DATA / "every_key.yaml").read_text(encoding="utf-8"), Loader))


def told(option):
    ended = mpirun(1, PROGRAM, option)
    assert ended.returncode == 0, ended.stderr
    return ended.stdout


@pytest.fixture(scope="module")
def schema():
    result = json.loads(told("-schema"))
    jsonschema.Draft7Validator.check_schema(result)
    return result


@pytest.fixture(scope="module")
def is_valid(schema):
    return jsonschema.Draft7Validator(schema).is_valid


def leaves_of(root, schema, value, path):
    """(name of the map's definition or "", schema, path) of the value and all that it holds. A path is a list of keys and places."""
    name = ""
    while True:
        if "$ref" in schema:
            name = schema["$ref"].rsplit("/", 1)[1]
            schema = root["definitions"][name]
        elif len(schema.get("allOf", [])) == 1 and "if" not in schema["allOf"][0]:
            schema = schema["allOf"][0]
        elif "anyOf" in schema:
            whole = [{**branch, "definitions": root["definitions"]} for branch in schema["anyOf"]]
            schema = next(branch for branch, one in zip(schema["anyOf"], whole) if jsonschema.Draft7Validator(one).is_valid(value))
        elif isinstance(value, dict) and "type" in schema.get("properties", {}) and "additionalProperties" not in schema:
            schema = next(rule["then"] for rule in schema["allOf"]
                          if rule["if"]["properties"]["type"]["const"] == value["type"])
        else:
            break
    yield name, schema, path
    if isinstance(value, dict):
        for key, child in value.items():
            inner = schema["properties"].get(key) or schema["additionalProperties"]
            yield from leaves_of(root, inner, child, [*path, key])
    if isinstance(value, list) and "items" in schema:
        for place, child in enumerate(value):
            yield from leaves_of(root, schema["items"], child, [*path, place])


@pytest.fixture(scope="module")
def leaves(schema):
    """A function: the leaves of an example, which are found once."""
    found = {}

    def of(scene):
        if scene["title"] not in found:
            found[scene["title"]] = list(leaves_of(schema, schema, scene, []))
        return found[scene["title"]]

    return of


def at(scene, path):
    for step in path:
        scene = scene[step]
    return scene


def changed(scene, path, value):
    scene = copy.deepcopy(scene)
    at(scene, path[:-1])[path[-1]] = value
    return scene


def part_at(scene, path):
    """The section that the path leads into, of a list of maps the one entry: what the schema says of it depends on nothing else."""
    if not path:
        return scene
    section = scene[path[0]]
    is_list_of_maps = isinstance(section, list) and all(isinstance(entry, dict) for entry in section)
    return {path[0]: [section[path[1]]] if is_list_of_maps and len(path) > 1 else section}


def wrong_values(schema, value):
    if "minimum" in schema:
        yield schema["minimum"] - 1
    if "exclusiveMinimum" in schema:
        yield schema["exclusiveMinimum"]
    if "maximum" in schema and schema["maximum"] < 2**53:
        yield schema["maximum"] + 1
    if "exclusiveMaximum" in schema:
        yield schema["exclusiveMaximum"]
    if schema.get("type") in ("number", "integer", "boolean", "array", "object") or "enum" in schema:
        yield "no_such_thing"
    if schema.get("type") == "array" and "maxItems" in schema and schema["maxItems"] == schema["minItems"]:
        yield [*value, value[-1]]
        yield value[:-1]


def text_of(path):
    return "".join(f"[{step}]" if isinstance(step, int) else f".{step}" for step in path).lstrip(".")


def refusal(scene, what=""):
    try:
        unibody.Scene(scene, folder=str(DATA))
    except unibody.InputError as error:
        return str(error)
    return f"nothing is wrong with {what}"


@pytest.mark.parametrize("scene", EXAMPLES, ids=[scene["title"] for scene in EXAMPLES])
def test_examples_are_scenes(scene, is_valid):
    assert is_valid(scene)
    for key, section in scene.items():
        for place in range(len(section) if isinstance(section, list) else 1):
            assert is_valid(part_at(scene, [key, place]))
    assert unibody.Scene(scene, folder=str(DATA)).title == scene["title"]


def test_examples_have_every_key(schema, leaves):
    seen = set()
    for scene in EXAMPLES:
        for name, of, path in leaves(scene):
            if isinstance(at(scene, path), dict):
                seen |= {(name, key) for key in at(scene, path) if key in of.get("properties", {})}
    wanted = {("", key) for key in schema["properties"]}
    for section in ("time", "solver", "output"):
        wanted |= {("", key) for key in schema["properties"][section]["allOf"][0]["properties"]}
    for name, of in schema["definitions"].items():
        if "additionalProperties" in of:
            wanted |= {(name, key) for key in of["properties"]}
    assert len(wanted) > 300
    assert wanted - seen == set()


@pytest.mark.parametrize("scene", EXAMPLES, ids=[scene["title"] for scene in EXAMPLES])
def test_what_the_schema_refuses_the_reader_refuses(scene, leaves, is_valid):
    count = 0
    for _, of, path in leaves(scene):
        for value in wrong_values(of, at(scene, path)) if path else []:
            wrong = changed(scene, path, value)
            if is_valid(part_at(wrong, path)):  # another form of the same key takes it
                continue
            message = refusal(wrong, value)
            assert f"key '{text_of(path)}" in message, (value, message)
            count += 1
    assert count > (1 if "columns" in scene["title"] else 15)


@pytest.mark.parametrize("scene", EXAMPLES, ids=[scene["title"] for scene in EXAMPLES])
def test_maps_take_their_own_keys_alone_and_need_those_that_are_required(scene, leaves, is_valid):
    for name, of, path in leaves(scene):
        value = at(scene, path)
        if not isinstance(value, dict) or "additionalProperties" not in of or of["additionalProperties"] is not False:
            continue
        more = copy.deepcopy(scene)
        at(more, path)["no_such_key"] = 1
        assert not is_valid(part_at(more, path))
        assert "no_such_key" in refusal(more), name
        for key in of.get("required", []):
            less = copy.deepcopy(scene)
            del at(less, path)[key]
            assert not is_valid(part_at(less, path))
            assert f"key '{text_of([*path, key])}': found nothing" in refusal(less)


JUNK = [None, 0, -1, 1, 1e300, 0.5, "x", "", "auto", True, [], {}, [1], [1, 2], [0, 0, 1], [[0, 0], [1, 1]], {"a": 1}, {"table": [[0, 1]]},
        {"sine": {"amplitude": 1, "frequency": 1}}, "world", "crate", "a", 2**60, float("nan"), [None], {"x": None}]


def paths_of(value, path=()):
    yield path
    if isinstance(value, dict):
        for key, child in value.items():
            yield from paths_of(child, (*path, key))
    if isinstance(value, list):
        for place, child in enumerate(value):
            yield from paths_of(child, (*path, place))


def test_scenes_changed_at_random(is_valid):
    """Each is read or refused with a sentence, and what the reader takes the schema takes too."""
    random = Random(1)
    taken = refused = 0
    for _ in range(1500):
        scene = copy.deepcopy(random.choice(EXAMPLES))
        path = random.choice([path for path in paths_of(scene) if path])
        if random.random() < 0.8:
            at(scene, path[:-1])[path[-1]] = copy.deepcopy(random.choice(JUNK))
        else:
            del at(scene, path[:-1])[path[-1]]
        try:
            unibody.Scene(scene, folder=str(DATA))
        except unibody.InputError as error:
            assert "found" in str(error) and "expected" in str(error), str(error)
            refused += 1
        else:
            assert is_valid(scene), (path, at(scene, path[:-1]))
            taken += 1
    assert min(taken, refused) > 100


def test_keys_that_a_generator_or_a_type_does_not_have(is_valid):
    for entry in ({"container": {"size": [1, 1]}, "mass": 1}, {"pile": {}, "shape": {}}, {"points": [[0, 0, 0]]}, {"mass": 1}):
        assert not is_valid({"bodies": [entry]}), entry
    joint = {"bodies": ["a", "b"], "anchor": [0, 0, 0]}
    assert not is_valid({"joints": [{**joint, "type": "ball", "motor": {"speed": 1, "max_torque": 1}}]})
    assert is_valid({"joints": [{**joint, "type": "hinge", "axis": [0, 0, 1], "motor": {"speed": 1, "max_torque": 1}}]})
    assert not is_valid({"joints": [{**joint, "type": "hinge", "axis": [0, 0, 1], "motor": {"speed": 1, "max_force": 1}}]})


def test_defaults_of_numbers_and_flags_are_what_a_map_has_without_the_key(leaves):
    """Where a default is said as a number, true or false, the scene that says it is the scene that leaves it out, bit for bit."""
    def state(scene):
        with unibody.Simulation(unibody.Scene(scene, folder=str(DATA), set={"time.frames": 1})) as simulation:
            simulation.step(2)
            return simulation.state_hash()

    checked = set()
    for scene in [scene for scene in EXAMPLES if "columns" not in scene["title"]]:
        for name, of, path in leaves(scene):
            value = at(scene, path)
            if not isinstance(value, dict) or not name:
                continue
            for key in value:
                default = re.search(r"; default: (\S+)$", of.get("properties", {}).get(key, {}).get("description", ""))
                if not default or not re.fullmatch(r"true|false|-?[0-9.]+(e-?[0-9]+)?", default.group(1)) or (name, key) in checked:
                    continue
                left_out = copy.deepcopy(scene)
                del at(left_out, path)[key]
                said = changed(scene, [*path, key], yaml.safe_load(default.group(1)) if "e" not in default.group(1)
                               or default.group(1) in ("true", "false") else float(default.group(1)))
                assert state(said) == state(left_out), text_of([*path, key])
                checked.add((name, key))
    assert len(checked) > 60


def rows_of(page):
    """(heading, key, unit, default) of each row of the page's tables that is about one key."""
    heading = ""
    for line in page.splitlines():
        if line.startswith("#"):
            heading = re.sub(r"[`#]", "", line).split(":")[0].strip()
        cells = [cell.strip() for cell in line.split("|")[1:-1]]
        if len(cells) == 5 and re.fullmatch(r"`[a-z_.\[\]]+`", cells[0]):
            yield heading, cells[0].strip("`"), cells[1], cells[2]


def test_the_guide_has_the_units_and_defaults_of_the_tables():
    tables = {(heading, key): (unit, default) for heading, key, unit, default in rows_of(told("-settings"))}
    names = {"bodies": "body", "cloths": "cloth", "threads": "thread", "solids": "solid", "joints": "joint", "when": "when",
             "pins": "pin", "regions": "region", "loads": "load"}
    inner = {"cloths.bending": "bending", "threads.bending": "thread_bending"}
    compared = 0
    pages = "\n".join(page.read_text(encoding="utf-8") for page in sorted((SOURCE / "docs").glob("scene-*.md"))
                      if page.name != "scene-keys.md")
    for heading, key, unit, default in rows_of(pages):
        parent, _, own = key.replace("[]", "").rpartition(".")
        table = inner.get(f"{heading}.{parent}") or names.get(parent or heading, parent or heading)
        if (table, own) not in tables:
            continue
        right_unit, right_default = tables[table, own]
        assert unit == right_unit, f"{heading}: {key}"
        if re.fullmatch(r"-?[0-9.]+(e-?[0-9]+)?", right_default):
            assert float(default) == float(right_default), f"{heading}: {key}"
        elif right_default in ("required", "true", "false"):
            assert default == right_default, f"{heading}: {key}"
        compared += 1
    assert compared > 80


def test_the_reference_page_is_what_the_program_says():
    assert (SOURCE / "docs" / "scene-keys.md").read_text(encoding="utf-8") == told("-settings"), \
        "write it anew: unibody -settings > docs/scene-keys.md"
