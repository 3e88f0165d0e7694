// Damage: what random changes make of texts and of files of bytes. Pure functions of their input and the state of the generator.
#pragma once

#include <random>
#include <string>

namespace unibody::fuzz {

using Random = std::mt19937_64;

// One to four changes: numbers and words replaced, lines dropped, doubled, moved and cut off, characters changed.
std::string damage_text(const std::string& text, Random& random);

// One to four changes: bits, bytes and eight-byte numbers replaced, parts dropped, doubled, zeroed and cut off. Nothing before
// `from`.
std::string damage_bytes(const std::string& bytes, Random& random, std::size_t from = 0);

}  // namespace unibody::fuzz
