// Shapes that need more than three lengths. Each reader checks its data and puts the shape into the library.
#pragma once

#include "scene/key.hpp"
#include "scene/scene.hpp"

namespace unibody {

// The file that `file` names by its path from the scene's folder; refused where none is there.
std::string surface_path(const Value& file, const Scene& scene);

const Keys& hull_keys();
const Keys& compound_keys();
const Keys& mesh_shape_keys();

// hull: {points: [[x, y, z], ...]}, or {mesh: FILE, scale: factor}: the hull of its nodes.
Shape read_hull(const Value& value, const Scene& scene);

// compound: {parts: [{shape, position, orientation}, ...]}, convex shapes in one frame; or {mesh: FILE, scale: factor,
// pieces: n}: a closed surface as convex pieces, n cells of its longest side, with the mass properties of the solid inside.
Shape read_compound(const Value& value, const Scene& scene);

// mesh: {file: FILE, scale: factor, sides: auto, front, back or both}, mended where it is no sound mesh; {height_field: {size,
// cells, heights or hills, seed}}; or {tube: {radius, length, sides}}: the inside of a drum about the z axis, with its two ends.
Shape read_mesh_shape(const Value& value, const Scene& scene);

// What a person should know of a shape that was read, as that a mesh was mended; empty if nothing.
std::string note_of(const Shape& shape);

}  // namespace unibody
