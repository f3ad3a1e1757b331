// Files that environment variables name, with tasks and ids of users' own.
#pragma once

namespace engram {

// Loads, once per process, the libraries of tasks that ENGRAM_TASKS names, separated by ':', then
// the variants of the file that ENGRAM_VARIANTS names, which may be of such tasks. Every API calls
// it before it looks for ids. Throws the errors of load_tasks and load_variants; the next call then
// tries again.
void load_environment_files();

}  // namespace engram
