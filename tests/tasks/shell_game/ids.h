// The short ids of the shell games, and the RL ids.
#pragma once

namespace engram::test::shell_game {

inline constexpr const char* kTouch = "ShellGameTouch-VLA-v0";
inline constexpr const char* kPush = "ShellGamePush-VLA-v0";
inline constexpr const char* kPick = "ShellGamePick-VLA-v0";
inline constexpr const char* kLamp = "ShellGameColorLampTouch-VLA-v0";
inline constexpr const char* kShuffle = "ShellGameShuffleTouch-VLA-v0";
inline constexpr const char* kShuffleLamp = "ShellGameShuffleColorLampTouch-VLA-v0";

inline constexpr const char* kTouchRl = "ShellGameTouch-v0";
inline constexpr const char* kPushRl = "ShellGamePush-v0";
inline constexpr const char* kPickRl = "ShellGamePick-v0";

}  // namespace engram::test::shell_game
