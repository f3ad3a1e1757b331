// Words for objects and their places.
#pragma once

#include <string>

namespace engram {

// "cross", "T shape", ...: of an index of kObjectShapeNames, spelled as in English; "object" for
// -1.
std::string shape_word(int shape);

// A length in metres, to the centimetre, "-0.12 m".
std::string in_metres(double metres);

}  // namespace engram
