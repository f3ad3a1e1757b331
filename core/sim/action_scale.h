// Full scale of the normalised control modes: what an action of 1 changes.
#pragma once

namespace engram {

inline constexpr double kTranslationScale = 0.1;  // m
inline constexpr double kRotationScale = 0.1;     // rad, of the TCP
inline constexpr double kJointScale = 0.1;        // rad

}  // namespace engram
