// Files of users' own tasks on the command line.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace engram::apps {

// Registers the tasks of a library, or of a Python file: one whose name ends in .py. Throws Error
// if that fails.
void load_task_file(const std::filesystem::path& file);

// The words of a command line in which `my_tasks.py:LampOrder-v0` stands for the id, behind the
// option --tasks=my_tasks.py. Those of `check` stay as they are.
std::vector<std::string> with_task_files(const std::vector<std::string>& words);

}  // namespace engram::apps
