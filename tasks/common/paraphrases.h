// Other wordings of the instructions, for training. None tells more than the instruction does.
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace engram {

// Ten or more, with the same numbers, or placeholders, as the instruction. Empty for one that is
// not the benchmark's.
std::vector<std::string> paraphrases(std::string_view instruction);

}  // namespace engram
