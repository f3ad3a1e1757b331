#include "core/scene/mujoco_handle.h"

#include <mujoco/mjxmacro.h>
#include <sys/mman.h>
#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <mutex>
#include <string_view>
#include <type_traits>

#include "core/base/error.h"
#include "core/scene/mujoco_versions.h"
#include "core/threads/process_mutex.h"

namespace engram {
namespace {

thread_local int scope_depth = 0;

using Handler = void (*)(const char*);
Handler previous_error = nullptr;
Handler previous_warning = nullptr;

// MuJoCo is C: it must not continue after an error, so the handler leaves by an exception that
// unwinds through its frames (Debian compiles them with unwind tables).
void on_error(const char* message) {
  if (scope_depth > 0) {
    const bool memory = std::strstr(message, "allocate") != nullptr;
    throw Error(memory ? Error::Kind::kUnavailable : Error::Kind::kInternal,
                std::string("MuJoCo: ") + message);
  }
  if (previous_error != nullptr) {
    previous_error(message);
    return;
  }
  // A foreign thread without a handler: MuJoCo's own default.
  std::fprintf(stderr, "ERROR: %s\n\n", message);
  std::exit(EXIT_FAILURE);
}

void on_warning(const char* message) {
  if (scope_depth > 0) return;
  if (previous_warning != nullptr) {
    previous_warning(message);
  } else {
    std::fprintf(stderr, "WARNING: %s\n\n", message);
  }
}

void install_handlers() {
  static std::once_flag once;
  std::call_once(once, [] {
    previous_error = mju_user_error;
    previous_warning = mju_user_warning;
    mju_user_error = on_error;
    mju_user_warning = on_warning;
  });
}

}  // namespace

MujocoScope::MujocoScope() {
  install_handlers();
  ++scope_depth;
}

MujocoScope::~MujocoScope() { --scope_depth; }

void PageDeleter::operator()(std::byte* pages) const noexcept { munmap(pages, bytes); }

namespace {

// Allocates zeros; a page takes up memory only once it is written.
std::unique_ptr<std::byte, PageDeleter> make_pages(std::size_t bytes) {
  constexpr int kProtection = PROT_READ | PROT_WRITE;
  void* pages = mmap(nullptr, bytes, kProtection, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
  if (pages == MAP_FAILED) {
    throw Error(Error::Kind::kUnavailable, "no memory for " + std::to_string(bytes) + " bytes");
  }
  return {static_cast<std::byte*>(pages), PageDeleter{bytes}};
}

// Returns pages of zeros to the system until they are written again.
void release_zero_pages(void* memory, std::size_t bytes) {
  const auto page = static_cast<std::size_t>(sysconf(_SC_PAGESIZE));
  void* next = memory;
  while (std::align(page, page, next, bytes) != nullptr) {
    auto* const begin = static_cast<std::byte*>(next);
    const bool zeros =
        std::all_of(begin, begin + page, [](std::byte byte) { return byte == std::byte{0}; });
    if (zeros) madvise(begin, page, MADV_DONTNEED);
    next = begin + page;
    bytes -= page;
  }
}

// A virtual file system with one file, a copy of a text.
class VirtualFile {
 public:
  static constexpr const char* kName = "scene.xml";

  explicit VirtualFile(const std::string& text);
  ~VirtualFile();
  VirtualFile(const VirtualFile&) = delete;
  VirtualFile& operator=(const VirtualFile&) = delete;

  const mjVFS* files() const { return files_; }

 private:
  std::unique_ptr<std::byte, PageDeleter> pages_;
  mjVFS* files_;
};

// In MuJoCo 2.2 the virtual file system is two megabytes. All zeros is an empty one; to clear it
// time and again would take a quarter of the time in which a scene is compiled.
VirtualFile::VirtualFile(const std::string& text)
    : pages_(make_pages(sizeof(mjVFS))), files_(reinterpret_cast<mjVFS*>(pages_.get())) {
#if mjVERSION_HEADER >= 300
  mj_defaultVFS(files_);
  mj_addBufferVFS(files_, kName, text.data(), static_cast<int>(text.size()));
#else
  mj_makeEmptyFileVFS(files_, kName, static_cast<int>(text.size()) + 1);
  std::memcpy(files_->filedata[0], text.c_str(), text.size() + 1);
#endif
}

VirtualFile::~VirtualFile() {
#if mjVERSION_HEADER >= 300
  mj_deleteVFS(files_);
#else
  mj_deleteFileVFS(files_, kName);
#endif
}

}  // namespace

ModelPtr compile_model(const std::string& mjcf) {
  const MujocoScope scope;
  const VirtualFile file(mjcf);
  char message[1000] = "";
  ModelPtr model;
  {
    // MuJoCo has a lock of its own here, which a child of fork() might find taken.
    const std::lock_guard lock(process_mutex(ProcessLock::kCompiler));
    model.reset(mj_loadXML(VirtualFile::kName, file.files(), message, sizeof message));
  }
  if (model == nullptr) {
    throw Error(Error::Kind::kInternal, std::string("scene refused by MuJoCo: ") + message);
  }
  collide_pairs_alone(*model);
  return model;
}

#if mjVERSION_HEADER >= 300

// Contacts and constraints lie in the arena, which MuJoCo allocates, but does not clear.
DataPtr make_data_lazy_contacts(const mjModel& model) {
  DataPtr data = make_data(model);
  release_zero_pages(data->buffer, static_cast<std::size_t>(data->nbuffer));
  return data;
}

#else

namespace {

// Calls f(array, bytes) for each array of mjData that holds contacts or constraints.
template <class F>
void for_each_contact_array(const mjModel* model, mjData& data, F&& f) {
  MJDATA_POINTERS_PREAMBLE(model)
  const auto is_contact_array = [](std::string_view rows, std::string_view columns) {
    return rows == "njmax" || rows == "nconmax" || columns.find("njmax") != std::string_view::npos;
  };
#define X(type, name, rows, columns)                                                             \
  if (is_contact_array(#rows, #columns)) {                                                       \
    f(data.name,                                                                                 \
      sizeof(type) * static_cast<std::size_t>(model->rows) * static_cast<std::size_t>(columns)); \
  }
  MJDATA_POINTERS
#undef X
}

}  // namespace

DataPtr make_data_lazy_contacts(const mjModel& model) {
  constexpr std::size_t kAlignment = 64;
  mjModel without_contacts = model;  // its arrays are the model's
  without_contacts.njmax = 0;
  without_contacts.nconmax = 0;
  DataPtr data = make_data(without_contacts);

  const auto rounded = [](std::size_t bytes) {
    return (bytes + kAlignment - 1) / kAlignment * kAlignment;
  };
  std::size_t total = kAlignment;  // never empty
  for_each_contact_array(&model, *data,
                         [&](auto* /*array*/, std::size_t bytes) { total += rounded(bytes); });
  data.get_deleter().contact_memory = make_pages(total);
  std::byte* next = data.get_deleter().contact_memory.get();
  for_each_contact_array(&model, *data, [&](auto*& array, std::size_t bytes) {
    array = reinterpret_cast<std::remove_reference_t<decltype(array)>>(next);
    next += rounded(bytes);
  });
  // Much of the rest stays zero as well: statistics of the solver, and arrays of other settings.
  release_zero_pages(data.get(), sizeof *data);
  release_zero_pages(data->buffer, static_cast<std::size_t>(data->nbuffer));
  return data;
}

#endif

DataPtr make_data(const mjModel& model) {
  const MujocoScope scope;
  DataPtr data(mj_makeData(&model));
  if (data == nullptr) {
    throw Error(Error::Kind::kUnavailable, "no memory for another mjData");
  }
  return data;
}

}  // namespace engram
