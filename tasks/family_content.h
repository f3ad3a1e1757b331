// Contents of users' families: hashes by which results name what they are of.
#pragma once

#include <string>

#include "tasks/family.h"

namespace engram {

// Names a family by the SHA-256 of what defines it, 64 digits. Called before its tasks are
// registered, for families that stay for the life of the process.
void set_content(const Family& family, const std::string& sha256);

// "" for families that nothing has named, such as built-in ones.
std::string content_of(const Family& family);

}  // namespace engram
