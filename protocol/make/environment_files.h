// Files that environment variables name, with tasks and ids of users' own.
#pragma once

#include "protocol/make/task_library.h"

namespace engram {

// Loads, once per process, the files of tasks that ENGRAM_TASKS names, separated by ':', then the
// variants of the file that ENGRAM_VARIANTS names, which may be of such tasks. Every API calls it
// before it looks for ids. Python files are for the command, which has a loader, and for the Python
// package, which loads them itself before; other programs have no use for them. Throws the errors
// of load_tasks, load_variants and the loader; the next call then tries again.
void load_environment_files(PythonLoader load_python = nullptr);

}  // namespace engram
