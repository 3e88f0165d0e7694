// The scene file's form, made of the tables of its keys.
#pragma once

#include <string>

namespace unibody {

// As a JSON schema (draft 7), for editors that complete and check YAML by one: all keys with their types, ranges, defaults and
// meanings. What of them depends on each other's values, beside types and generators, is checked by read_scene() alone.
std::string scene_schema();

// As a page in Markdown: a table of the settings, and one of the keys of each map.
std::string keys_reference();

}  // namespace unibody
