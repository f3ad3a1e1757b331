// A policy in a process of its own, which reads requests from its standard input and writes answers
// to its standard output (docs/evaluation.md has the protocol).
#pragma once

#include <chrono>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>

#include "protocol/eval/policies/external_policy.h"
#include "protocol/eval/policies/guarded_process.h"
#include "protocol/io/bytes.h"
#include "protocol/io/json.h"

namespace engram {

struct PolicyProcessOptions {
  std::string command;                         // for /bin/sh
  std::string server = {};                     // for which the command speaks, if it does
  std::chrono::milliseconds timeout{300'000};  // for every answer, its request included
  BatchOptions environment;                    // observations and control mode count
  int max_slots = 1;                           // episodes under way at the same time, at most
  bool choices = false;                        // it names answers instead of sending actions
  // Called with the JSON object of each message in which the policy tells what it is.
  std::function<void(const Json&)> identified = {};
};

// Writing to a process that has ended raises SIGPIPE: programs that use this class ignore that
// signal. Throws Error (kUnavailable) when the process cannot be started, ends, does not answer in
// time, breaks the protocol or reports a failure.
class PolicyProcess final : public ExternalPolicy {
 public:
  // context: of the item at hand, which may be stopped before the process has answered.
  PolicyProcess(const PolicyProcessOptions& options, const WorkContext& context);
  // Connects to a running policy, and closes these descriptors at the end.
  PolicyProcess(int to, int from, const PolicyProcessOptions& options, const WorkContext& context);
  // Closes its input, waits two seconds at most for its end, and ends whatever is left of it and of
  // the processes that it has started.
  ~PolicyProcess() override;
  PolicyProcess(const PolicyProcess&) = delete;
  PolicyProcess& operator=(const PolicyProcess&) = delete;

  void act(const PolicyRequest& request, PolicyReply& reply) override;
  void choose(const ChoiceQuestion& question, ChoiceAnswer& answer) override;
  void check_no_pending_reply() override;

 private:
  enum class Message : std::uint32_t {
    kHello = 1,
    kTask,
    kRequest,
    kChunks,
    kFailed,
    kQuestion,
    kChoice,
    kIdentity = 9
  };
  using Clock = std::chrono::steady_clock;

  void handshake();
  // Begins an exchange; where: for messages.
  void begin(const WorkContext* context, int step, int episode, std::string_view env_id);
  void send_task(std::string_view env_id, int state_dim, std::uint64_t policy_seed);
  void send_request(const PolicyRequest& request);
  void send_question(const ChoiceQuestion& question);
  void read_chunks(std::span<const std::byte> answer, int rows, PolicyReply& reply) const;
  void send_message(Message message, std::span<const std::byte> body);
  Bytes receive_message(Message expected);
  Bytes read_body(std::uint32_t size);
  void take_identity(std::uint32_t size);
  void write(std::span<const std::byte> bytes);
  void read(std::span<std::byte> bytes);
  void wait_for(int descriptor, short events) const;
  // Throws an Error with the exit status of the process.
  [[noreturn]] void fail_closed() const;
  [[noreturn]] void fail_reported(std::uint32_t size);
  [[noreturn]] void fail(const std::string& what) const;
  void stop();

  PolicyProcessOptions options_;
  std::optional<GuardedProcess> process_;  // none if the policy was running already
  int to_ = -1;                            // its standard input
  int from_ = -1;                          // its standard output
  std::string task_;
  std::uint64_t policy_seed_ = 0;
  std::string request_;         // for messages
  const WorkContext* context_;  // while an answer is waited for
  Clock::time_point deadline_;
};

}  // namespace engram
