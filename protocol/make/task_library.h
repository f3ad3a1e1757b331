// Libraries of users' own tasks, which are loaded while the process runs (docs/cpp_tasks.md).
#pragma once

#include <filesystem>
#include <string_view>

namespace engram {

// Loads a library of tasks and registers its families for the life of the process, all or none;
// the same library twice is one. Throws Error: kIo if the file cannot be read; kInvalidArgument,
// naming the file, if it is no such library, was made for another version or with another ABI, or
// one of its ids is taken.
void load_tasks(const std::filesystem::path& file);

// Registers the tasks of a Python file. Throws Error.
using PythonLoader = void (*)(const std::filesystem::path& file);

// Loads each of several files that are separated by ':'; empty ones are left out. Files whose name
// ends in .py go to load_python; without it they are left out, too.
void load_task_list(std::string_view files, PythonLoader load_python = nullptr);

}  // namespace engram
