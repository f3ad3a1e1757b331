#include "protocol/eval/policies/policy_process.h"

#include <fcntl.h>
#include <poll.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>

#include "core/observe/proprio.h"
#include "core/sim/action_dim.h"
#include "protocol/eval/policies/choice_question.h"
#include "protocol/io/printable.h"

namespace engram {
namespace {

constexpr std::uint32_t kVersion = 1;
constexpr std::uint32_t kMagic = 0x4d474e45;  // "ENGM" as it lies in memory
constexpr std::uint32_t kMaxReply = std::uint32_t{1} << 28;
constexpr std::uint32_t kMaxFailure = 2000;  // bytes of a reported failure that are read
constexpr std::uint32_t kMaxIdentity = 65'536;
constexpr std::uint32_t kObservesRgb = 1;
constexpr std::uint32_t kObservesState = 2;
constexpr std::uint32_t kObservesObjects = 3;

void close(int& descriptor) {
  if (descriptor >= 0) ::close(descriptor);
  descriptor = -1;
}

// Both ends of a pipe, closed in other processes.
std::array<int, 2> make_pipe() {
  std::array<int, 2> ends{};
  if (::pipe2(ends.data(), O_CLOEXEC) != 0) {
    throw Error(Error::kUnavailable, std::string("policy: no pipe: ") + std::strerror(errno));
  }
  return ends;
}

}  // namespace

PolicyProcess::PolicyProcess(const PolicyProcessOptions& options, const WorkContext& context)
    : options_(options), context_(&context) {
  std::array<int, 2> input = make_pipe();
  std::array<int, 2> output = make_pipe();
  to_ = input[1];
  from_ = output[0];
  try {
    process_.emplace(options_.command, input[0], output[1]);
    close(input[0]);
    close(output[1]);
    handshake();
  } catch (...) {
    close(input[0]);
    close(output[1]);
    stop();
    throw;
  }
}

PolicyProcess::PolicyProcess(int to, int from, const PolicyProcessOptions& options,
                             const WorkContext& context)
    : options_(options), to_(to), from_(from), context_(&context) {
  try {
    handshake();
  } catch (...) {
    stop();
    throw;
  }
}

PolicyProcess::~PolicyProcess() { stop(); }

void PolicyProcess::stop() {
  close(to_);
  close(from_);
  if (!process_) return;
  process_->wait(std::chrono::seconds(2));
  process_.reset();
}

// --- messages ---

void PolicyProcess::handshake() {
  // Limits the wait for a full pipe to the timeout.
  ::fcntl(to_, F_SETFL, O_NONBLOCK);
  deadline_ = Clock::now() + options_.timeout;
  const ImageShape& images = options_.environment.images;
  const bool rgb = options_.environment.obs_mode == ObsMode::kRgb;
  ByteWriter body;
  body.put(kMagic);
  body.put(kVersion);
  const bool objects = observes_objects(options_.environment.obs_mode);
  body.put(rgb ? kObservesRgb : objects ? kObservesObjects : kObservesState);
  body.put(static_cast<std::uint32_t>(rgb ? images.height : 0));
  body.put(static_cast<std::uint32_t>(rgb ? images.width : 0));
  body.put(static_cast<std::uint32_t>(rgb ? 3 * images.cameras.size() : 0));
  body.put(static_cast<std::uint32_t>(proprio_dim(options_.environment.joint_proprio)));
  const int numbers =
      options_.choices
          ? 0
          : action_dim(options_.environment.control_mode.value_or(ControlMode::kPdEeDeltaPose));
  body.put(static_cast<std::uint32_t>(numbers));
  body.put(static_cast<std::uint32_t>(options_.max_slots));
  request_ = "the greeting";
  send_message(Message::kHello, body.bytes());
  const Bytes answer = receive_message(Message::kHello);
  ByteReader in(answer);
  const bool understood = answer.size() == 2 * sizeof(std::uint32_t) &&
                          in.get<std::uint32_t>() == kMagic && in.get<std::uint32_t>() == kVersion;
  if (!understood) fail("answered the greeting with something else than version 1 of the protocol");
}

void PolicyProcess::begin(const WorkContext* context, int step, int episode,
                          std::string_view env_id) {
  context_ = context;
  deadline_ = Clock::now() + options_.timeout;
  check_no_pending_reply();
  request_ = "step " + std::to_string(step) + " of episode " + std::to_string(episode) + " of " +
             std::string(env_id);
}

void PolicyProcess::act(const PolicyRequest& request, PolicyReply& reply) {
  begin(request.context, request.steps[0], request.episodes[0], request.env_id);
  send_task(request.env_id, request.state_dim, request.policy_seed);
  send_request(request);
  const Bytes answer = receive_message(Message::kChunks);
  try {
    read_chunks(answer, request.count, reply);
  } catch (const Error& error) {
    if (error.kind() == Error::kUnavailable) throw;
    fail(std::string("answered: ") + error.what());
  }
}

void PolicyProcess::choose(const ChoiceQuestion& question, ChoiceAnswer& answer) {
  begin(question.context, question.step, question.episode, question.env_id);
  send_task(question.env_id, question.state_dim, question.policy_seed);
  send_question(question);
  const Bytes bytes = receive_message(Message::kChoice);
  try {
    ByteReader in(bytes);
    std::vector<std::string> texts;
    const auto count = in.get<std::uint32_t>();
    if (count > static_cast<std::uint32_t>(question.form.most)) {
      fail("answered at " + request_ + ": " + std::to_string(count) + " choices given, at most " +
           std::to_string(question.form.most) + " allowed");
    }
    for (std::uint32_t i = 0; i < count; ++i) texts.push_back(in.text());
    if (!in.rest().empty()) fail("answered with bytes to spare");
    answer.set(texts);
  } catch (const Error& error) {
    if (error.kind() == Error::kUnavailable) throw;
    fail(std::string("answered at ") + request_ + ": " + error.what());
  }
}

void PolicyProcess::send_task(std::string_view env_id, int state_dim, std::uint64_t policy_seed) {
  if (task_ == env_id && policy_seed_ == policy_seed) return;
  task_ = env_id;
  policy_seed_ = policy_seed;
  ByteWriter body;
  body.put(env_id);
  body.put(static_cast<std::uint32_t>(state_dim));
  // Policies that were written before there was one see none.
  if (policy_seed_ != 0) body.put(policy_seed_);
  send_message(Message::kTask, body.bytes());
}

void PolicyProcess::send_question(const ChoiceQuestion& question) {
  ByteWriter body;
  for (const std::int32_t number :
       {question.slot, question.number, question.step, question.index}) {
    body.put(number);
  }
  body.put(std::string_view(question.instruction));
  body.put(std::string_view(question.form.question));
  for (const int number : {question.form.least, question.form.most, int{question.form.repeats}}) {
    body.put(static_cast<std::uint32_t>(number));
  }
  const auto put_texts = [&body](std::span<const std::string> texts) {
    for (const std::string& text : texts) body.put(std::string_view(text));
  };
  body.put(static_cast<std::uint32_t>(question.choices.size()));
  put_texts(question.choices);
  body.put(static_cast<std::uint32_t>(question.steps.size()));
  body.append(question.steps);
  body.append(question.proprio);
  body.append(question.rgb);
  body.append(question.state);
  put_texts(question.texts);
  if (question.seed) body.put(*question.seed);
  send_message(Message::kQuestion, body.bytes());
}

void PolicyProcess::send_request(const PolicyRequest& request) {
  ByteWriter body;
  body.put(static_cast<std::uint32_t>(request.count));
  body.append(request.slots);
  body.append(request.numbers);
  body.append(request.steps);
  body.append(request.first);
  for (const std::string& instruction : request.instructions)
    body.put(std::string_view(instruction));
  body.append(request.proprio);
  body.append(request.rgb);
  body.append(request.state);
  body.append(request.seeds);
  send_message(Message::kRequest, body.bytes());
}

void PolicyProcess::read_chunks(std::span<const std::byte> answer, int rows,
                                PolicyReply& reply) const {
  ByteReader in(answer);
  const auto count = in.get<std::uint32_t>();
  if (count != static_cast<std::uint32_t>(rows)) {
    fail("answered " + std::to_string(count) + " rows, " + std::to_string(rows) + " asked for");
  }
  for (int row = 0; row < rows; ++row) {
    const auto dims = in.get<std::uint32_t>();
    if (dims > 3) fail("answered with " + std::to_string(dims) + " dimensions, 1 to 3 allowed");
    std::array<std::int64_t, 3> shape{};
    std::size_t size = 1;
    for (std::uint32_t i = 0; i < dims; ++i) {
      shape[i] = in.get<std::uint32_t>();
      size *= static_cast<std::size_t>(std::min<std::int64_t>(shape[i], kMaxReply));
      if (size > kMaxReply) fail("announced " + std::to_string(size) + " numbers");
    }
    const std::vector<float> actions = in.values<float>(size);
    reply.set(row, actions, std::span<const std::int64_t>(shape.data(), dims));
  }
  if (!in.rest().empty()) fail("answered with bytes to spare");
}

// Bytes in the pipe before the next request would be taken for its answer.
void PolicyProcess::check_no_pending_reply() {
  pollfd one{from_, POLLIN, 0};
  if (::poll(&one, 1, 0) <= 0 || (one.revents & POLLIN) == 0) return;
  std::array<std::byte, 4096> more{};
  const ssize_t count = ::read(from_, more.data(), more.size());
  if (count <= 0) return;  // it has ended, which the next request reports
  fail("said " + std::to_string(count) + " bytes too many after its answer to " + request_ +
       ": one answer to each question allowed; does it print to standard output?");
}

void PolicyProcess::send_message(Message message, std::span<const std::byte> body) {
  ByteWriter head;
  head.put(static_cast<std::uint32_t>(message));
  head.put(static_cast<std::uint32_t>(body.size()));
  write(head.bytes());
  write(body);
}

Bytes PolicyProcess::receive_message(Message expected) {
  std::uint32_t message = 0;
  std::uint32_t size = 0;
  const auto read_head = [&] {
    Bytes head(2 * sizeof(std::uint32_t));
    read(head);
    ByteReader in(head);
    message = in.get<std::uint32_t>();
    size = in.get<std::uint32_t>();
  };
  read_head();
  if (message == static_cast<std::uint32_t>(Message::kIdentity) && size <= kMaxIdentity) {
    take_identity(size);
    read_head();
  }
  const bool known = message == static_cast<std::uint32_t>(expected) ||
                     message == static_cast<std::uint32_t>(Message::kFailed);
  if (!known || size > kMaxReply) {
    fail("answered with message type " + std::to_string(message) + " of " + std::to_string(size) +
         " bytes, type " + std::to_string(static_cast<std::uint32_t>(expected)) +
         " expected; does it print to standard output?");
  }
  if (message == static_cast<std::uint32_t>(Message::kFailed)) fail_reported(size);
  return read_body(size);
}

// Memory grows as bytes arrive, not by the announced size.
Bytes PolicyProcess::read_body(std::uint32_t size) {
  constexpr std::size_t kSlice = std::size_t{1} << 20;
  Bytes body;
  while (body.size() < size) {
    const std::size_t start = body.size();
    body.resize(std::min<std::size_t>(size, start + kSlice));
    read(std::span(body).subspan(start));
  }
  return body;
}

void PolicyProcess::take_identity(std::uint32_t size) {
  const Bytes body = read_body(size);
  const std::string_view text(reinterpret_cast<const char*>(body.data()), body.size());
  const std::optional<Json> told = parse_json(text);
  if (!told || !is_table(*told)) fail("told of itself something else than a JSON object");
  if (options_.identified) options_.identified(*told);
}

// --- pipes ---

void PolicyProcess::write(std::span<const std::byte> bytes) {
  while (!bytes.empty()) {
    const ssize_t written = ::write(to_, bytes.data(), bytes.size());
    if (written >= 0) {
      bytes = bytes.subspan(static_cast<std::size_t>(written));
    } else if (errno == EAGAIN) {
      wait_for(to_, POLLOUT);
    } else if (errno != EINTR) {
      fail_closed();
    }
  }
}

void PolicyProcess::read(std::span<std::byte> bytes) {
  while (!bytes.empty()) {
    wait_for(from_, POLLIN);
    const ssize_t count = ::read(from_, bytes.data(), bytes.size());
    if (count > 0) {
      bytes = bytes.subspan(static_cast<std::size_t>(count));
    } else if (count == 0 || errno != EINTR) {
      fail_closed();
    }
  }
}

void PolicyProcess::wait_for(int descriptor, short events) const {
  constexpr std::chrono::milliseconds kSlice{100};
  while (true) {
    // Checked before the pipe: one that takes or gives a byte now and then is late all the same.
    if (context_ != nullptr && context_->stopped()) fail("was not waited for");
    const auto left = std::chrono::ceil<std::chrono::milliseconds>(deadline_ - Clock::now());
    if (left.count() <= 0) {
      const auto seconds = std::chrono::duration_cast<std::chrono::seconds>(options_.timeout);
      fail("has not answered within " + std::to_string(seconds.count()) + " s");
    }
    // Checked before the pipe, so that bytes written before the end are still read.
    const bool gone = process_ && process_->ending();
    pollfd one{descriptor, events, 0};
    if (::poll(&one, 1, gone ? 0 : static_cast<int>(std::min(left, kSlice).count())) > 0) return;
    if (gone) fail_closed();
  }
}

void PolicyProcess::fail_closed() const {
  // Its pipe may close a moment before the process itself is gone.
  if (process_) process_->wait(std::chrono::seconds(1));
  if (const auto ending = process_ ? process_->ending() : std::nullopt) {
    const std::string how = std::to_string(ending->status);
    fail(ending->exited ? "ended with exit code " + how : "was ended by signal " + how);
  }
  fail("closed its standard input or output");
}

// Reads the beginning of a failure that the policy reports; the rest would tell no more.
void PolicyProcess::fail_reported(std::uint32_t size) {
  Bytes body(std::min(size, kMaxFailure));
  read(body);
  const std::string_view words(reinterpret_cast<const char*>(body.data()), body.size());
  const std::string message = printable(words) + (size > kMaxFailure ? "..." : "");
  if (!options_.server.empty()) throw Error(Error::kUnavailable, message);  // names it
  fail("says: " + message);
}

void PolicyProcess::fail(const std::string& what) const {
  const bool server = !options_.server.empty();
  const std::string who = server ? "server '" + options_.server : "'" + options_.command;
  throw Error(Error::kUnavailable, "policy " + who + "' " + what);
}

}  // namespace engram
