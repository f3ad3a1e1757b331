#include "apps/task_process.h"

#include <fmt/format.h>
#include <sys/mman.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <mutex>
#include <optional>

#include "apps/message_socket.h"
#include "apps/python_module.h"
#include "core/base/error.h"
#include "protocol/custom_tasks/task_documents.h"
#include "protocol/eval/policies/guarded_process.h"
#include "protocol/io/json.h"
#include "tasks/custom/custom_family.h"

namespace engram::apps {
namespace {

using tasks::CustomArray;
using tasks::CustomMethod;

[[noreturn]] void fail(const std::string& message) { throw Error(Error::kTaskFailed, message); }

// Receives an answer: a table, without "error". Throws Error (kTaskFailed).
Json answer(MessageSocket& socket, const std::string& what) {
  const std::optional<std::string> message = socket.receive();
  if (!message) fail(what + ": its process has ended");
  std::optional<Json> document = parse_json(*message);
  if (!document) fail(what + ": its process has answered something else than JSON");
  if (const Json* error = find(*document, "error")) fail(what + ": " + text(*error));
  return std::move(*document);
}

// Memory that the process has, too.
class SharedRows {
 public:
  explicit SharedRows(std::size_t bytes)
      : bytes_(bytes), file_(::memfd_create("engram-task", MFD_CLOEXEC)) {
    if (file_.number() < 0 || ::ftruncate(file_.number(), static_cast<off_t>(bytes)) != 0) refuse();
    void* const memory =
        ::mmap(nullptr, bytes, PROT_READ | PROT_WRITE, MAP_SHARED, file_.number(), 0);
    if (memory == MAP_FAILED) refuse();
    memory_ = static_cast<std::byte*>(memory);
  }
  ~SharedRows() {
    if (memory_ != nullptr) ::munmap(memory_, bytes_);
  }
  SharedRows(const SharedRows&) = delete;
  SharedRows& operator=(const SharedRows&) = delete;

  int file() const { return file_.number(); }
  std::byte* memory() const { return memory_; }

 private:
  [[noreturn]] static void refuse() {
    throw Error(Error::kUnavailable,
                std::string("no memory to share with a task's process: ") + std::strerror(errno));
  }

  std::size_t bytes_;
  Descriptor file_;
  std::byte* memory_ = nullptr;
};

// One instance, in a process of its own.
class ProcessInstance final : public tasks::CustomInstance {
 public:
  ProcessInstance(MessageSocket socket, const std::string& id)
      : socket_(std::move(socket)), what_("task '" + id + "'") {
    description_ = parse_task_description(to_line(part(answer(socket_, what_), "description")), id);
  }

  const tasks::CustomDescription& description() const override { return description_; }
  bool sees_batch() const override { return false; }

  std::shared_ptr<std::byte> spare_memory(std::size_t bytes) override {
    rows_ = std::make_shared<SharedRows>(std::max<std::size_t>(bytes, 1));
    return {rows_, rows_->memory()};
  }

  void bind(std::span<const CustomArray> arrays, int num_envs) override {
    JsonList list;
    for (const CustomArray& array : arrays) {
      list.push_back(JsonTable{{"name", array.field.name},
                               {"dtype", dtype_name(array.field.dtype)},
                               {"width", array.field.width},
                               {"is_written", array.is_written},
                               {"offset", array.subset_rows - rows_->memory()}});
    }
    const Json message = JsonTable{{"bind", JsonTable{{"arrays", list}, {"num_envs", num_envs}}}};
    if (!socket_.send(to_line(message), rows_->file())) fail(what_ + ": its process has ended");
    answer(socket_, what_);
  }

  // The message of a call is three numbers; the answer is empty if all is well.
  void call(CustomMethod method, int rows, bool /*of_all*/) override {
    if (!socket_.send(fmt::format("call {} {}", static_cast<int>(method), rows))) {
      fail(what_ + ": its process has ended");
    }
    const std::optional<std::string> message = socket_.receive();
    if (!message) fail(what_ + ": its process has ended");
    if (message->empty()) return;
    const std::optional<Json> document = parse_json(*message);
    fail(what_ + ": " + (document ? text(part(*document, "error")) : *message));
  }

 private:
  MessageSocket socket_;
  std::string what_;
  std::shared_ptr<SharedRows> rows_;
  tasks::CustomDescription description_;
};

// The process that has loaded the file. It forks one for each instance.
class TaskProcess {
 public:
  explicit TaskProcess(const std::string& file) : what_("tasks of '" + file + "'") {
    std::vector<std::string> words = python_words("engram.kit", "a Python file of tasks");
    words.push_back(file);
    auto [own, other] = MessageSocket::pair();
    socket_ = std::move(own);
    // What the file prints is no result of this command.
    process_.emplace(shell_command(words), other.number(), STDERR_FILENO);
  }

  // The definitions of its tasks, as JSON.
  std::vector<std::string> definitions() {
    const std::optional<std::string> message = socket_.receive();
    if (!message) {
      process_->wait(std::chrono::seconds(2));
      throw Error(Error::kUnavailable, what_ + ": its process has ended");
    }
    const std::optional<Json> document = parse_json(*message);
    if (!document) fail(what_ + ": not loaded");
    if (const Json* error = find(*document, "error")) fail(what_ + ": " + text(*error));
    std::vector<std::string> texts;
    for (const Json& one : list(part(*document, "definitions"))) texts.push_back(to_line(one));
    return texts;
  }

  std::unique_ptr<tasks::CustomInstance> make(const std::string& id,
                                              const ConstantTable& constants) {
    auto [own, other] = MessageSocket::pair();
    const Json message = JsonTable{{"id", id}, {"constants", constants}};
    {
      const std::scoped_lock lock(mutex_);
      if (!socket_.send(to_line(message), other.number())) fail(what_ + ": its process has ended");
    }
    other = Descriptor();
    return std::make_unique<ProcessInstance>(std::move(own), id);
  }

 private:
  std::string what_;
  std::mutex mutex_;  // of what is sent
  MessageSocket socket_;
  std::optional<GuardedProcess> process_;
};

class ProcessFactory final : public tasks::CustomFactory {
 public:
  explicit ProcessFactory(std::shared_ptr<TaskProcess> process) : process_(std::move(process)) {}

  std::unique_ptr<tasks::CustomInstance> make(const std::string& id,
                                              const ConstantTable& constants) const override {
    return process_->make(id, constants);
  }

 private:
  std::shared_ptr<TaskProcess> process_;
};

}  // namespace

void load_python_tasks(const std::string& file) {
  auto process = std::make_shared<TaskProcess>(file);
  const auto factory = std::make_shared<ProcessFactory>(process);
  for (const std::string& definition : process->definitions()) {
    tasks::register_custom(parse_definition(definition), factory);
  }
}

}  // namespace engram::apps
