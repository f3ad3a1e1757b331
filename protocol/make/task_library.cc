#include "protocol/make/task_library.h"

#include <dlfcn.h>
#include <elf.h>

#include <algorithm>
#include <fstream>
#include <memory>
#include <span>
#include <string>

#include "core/base/error.h"
#include "core/base/sha256.h"
#include "protocol/io/files.h"
#include "tasks/family_content.h"
#include "tasks/registry.h"
#include "tasks/task_library.h"

namespace engram {
namespace {

namespace fs = std::filesystem;

constexpr const char* kRebuild = "; compile it again, with the headers of this engram";

struct CloseLibrary {
  void operator()(void* library) const { ::dlclose(library); }
};
using OpenLibrary = std::unique_ptr<void, CloseLibrary>;

[[noreturn]] void refuse(const std::string& why) { throw Error(Error::kInvalidArgument, why); }

std::string_view view(const char* text) { return text == nullptr ? std::string_view() : text; }
std::string quoted(const char* text) { return "'" + std::string(view(text)) + "'"; }

// Throws Error unless the file is as long as its own headers say: dlopen maps what they name, and
// the process would end where the file has ended.
void require_whole(const fs::path& file) {
  std::ifstream stream(file, std::ios::binary);
  const auto read = [&stream](std::uint64_t offset, auto& header) {
    stream.seekg(static_cast<std::streamoff>(offset));
    return static_cast<bool>(stream.read(reinterpret_cast<char*>(&header), sizeof header));
  };
  const std::uint64_t size = fs::file_size(file);
  const auto holds = [size](std::uint64_t offset, std::uint64_t bytes) {
    return offset <= size && bytes <= size - offset;
  };
  Elf64_Ehdr elf{};
  if (!read(0, elf) ||
      !std::ranges::equal(std::span(elf.e_ident, SELFMAG), std::string_view(ELFMAG))) {
    refuse("not a library");
  }
  bool whole = holds(elf.e_shoff, std::uint64_t{elf.e_shnum} * elf.e_shentsize);
  for (std::uint64_t i = 0; whole && i < elf.e_phnum; ++i) {
    Elf64_Phdr segment{};
    whole = read(elf.e_phoff + i * sizeof segment, segment) &&
            holds(segment.p_offset, segment.p_filesz);
  }
  if (!whole) refuse("a library that is cut off, at " + std::to_string(size) + " bytes");
}

// Nothing of the library is visible to others, and all that it needs is found now, not later.
OpenLibrary open_library(const fs::path& file) {
  require_whole(file);
  // A name without a folder would be looked for in the system's folders.
  const std::string path = fs::absolute(file).string();
  OpenLibrary library(::dlopen(path.c_str(), RTLD_NOW | RTLD_LOCAL));
  if (library == nullptr) refuse(std::string("not a library that can be loaded: ") + ::dlerror());
  return library;
}

const TaskLibrary& described_by(void* library) {
  void* const symbol = ::dlsym(library, kTaskLibraryFunction);
  if (symbol == nullptr) {
    refuse("a library without the function " + std::string(kTaskLibraryFunction) +
           "; one with ENGRAM_TASKS(...) in a source file needed");
  }
  const TaskLibrary* description = reinterpret_cast<TaskLibraryFunction*>(symbol)();
  if (description == nullptr) {
    refuse(std::string(kTaskLibraryFunction) + " returned NULL; one with ENGRAM_TASKS(...) needed");
  }
  return *description;
}

// The version first: what else it says may differ because of it.
void require_compatible(const TaskLibrary& library) {
  if (view(library.version) != ENGRAM_TASKS_VERSION) {
    refuse("made for engram " + quoted(library.version) + ", this is " +
           quoted(ENGRAM_TASKS_VERSION) + kRebuild);
  }
  if (view(library.abi) != ENGRAM_TASKS_ABI) {
    refuse("another ABI: made with " + quoted(library.abi) + ", this engram with " +
           quoted(ENGRAM_TASKS_ABI) + "; the same compiler and flags needed");
  }
  if (library.bytes != sizeof(TaskLibrary) || view(library.headers) != ENGRAM_TASKS_HEADERS) {
    refuse("made with other headers of engram " + quoted(ENGRAM_TASKS_VERSION) + ": checksum " +
           quoted(library.headers) + ", this engram has " + quoted(ENGRAM_TASKS_HEADERS) +
           kRebuild);
  }
}

bool are_registered(std::span<const Family* const> families) {
  return std::ranges::all_of(families, [](const Family* family) {
    return std::ranges::all_of(family->tasks, [&](const TaskSpec& row) {
      const RegistryEntry* entry = find_entry(row.id);
      return entry != nullptr && entry->definition == family;
    });
  });
}

void register_library(const fs::path& file) {
  OpenLibrary library = open_library(file);
  const TaskLibrary& description = described_by(library.get());
  require_compatible(description);
  const std::span families(description.families, description.count);
  if (std::ranges::find(families, nullptr) != families.end()) {
    refuse("a library with NULL in place of a family; ENGRAM_TASKS(...) names families");
  }
  if (std::ranges::all_of(families, [](const Family* family) { return family->tasks.empty(); })) {
    refuse("a library without tasks; one row of a family's table or more needed");
  }
  if (are_registered(families)) return;
  const std::string content = to_hex(sha256(read_input(file).value_or("")));
  for (const Family* family : families) set_content(*family, content);
  register_families(families);
  library.release();  // NOLINT(bugprone-unused-return-value): it stays for the process's life
}

}  // namespace

void load_tasks(const fs::path& file) {
  std::error_code ignored;
  if (!fs::is_regular_file(file, ignored)) {
    throw Error(Error::kIo, "'" + file.string() + "' cannot be read; a library of tasks needed");
  }
  try {
    register_library(file);
  } catch (const Error& error) {
    throw Error(error.kind(), "tasks of '" + file.string() + "': " + error.what());
  }
}

void load_task_list(std::string_view files, PythonLoader load_python) {
  while (!files.empty()) {
    const std::size_t end = std::min(files.find(':'), files.size());
    const fs::path file = files.substr(0, end);
    if (file.extension() == ".py") {
      if (load_python != nullptr) load_python(file);
    } else if (!file.empty()) {
      load_tasks(file);
    }
    files.remove_prefix(std::min(end + 1, files.size()));
  }
}

}  // namespace engram
