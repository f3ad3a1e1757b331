// Ids of the RL tasks of BunchOfColors, SeqOfColors and ChainOfColors.
#pragma once

#include <string>
#include <string_view>

namespace engram::test::touch_colors {

inline constexpr const char* kFamilies[] = {"BunchOfColors", "SeqOfColors", "ChainOfColors"};

inline bool is_bunch(std::string_view id) { return id.starts_with("Bunch"); }
inline bool is_chain(std::string_view id) { return id.starts_with("Chain"); }
// The first step in which the robot may act.
inline int start_of(std::string_view id, int length) { return is_bunch(id) ? 10 : 5 * length + 5; }

inline std::string three(const char* family) { return std::string(family) + "3-v0"; }

}  // namespace engram::test::touch_colors
