// The processes of one run: one alone, or several under mpirun.
#pragma once

#include <array>
#include <memory>
#include <optional>

#include "protocol/io/bytes.h"

namespace engram {

// Rank 0, the root, coordinates and writes files; the others are workers. This base class is for a
// single process. Not for use from two threads at once.
class Ranks {
 public:
  struct Message {
    int from = 0;
    Bytes bytes;
  };

  Ranks() = default;
  virtual ~Ranks() = default;
  Ranks(const Ranks&) = delete;
  Ranks& operator=(const Ranks&) = delete;

  virtual int rank() const { return 0; }
  virtual int size() const { return 1; }
  // Ranks on this machine, which share its cores.
  virtual int local_size() const { return 1; }

  // Does not wait for the receiver. Messages from one rank to another arrive in their order.
  virtual void send(int /*to*/, Bytes /*bytes*/) {}
  // A message that has arrived, if there is one.
  virtual std::optional<Message> receive() { return std::nullopt; }
  // Ends all processes: the run has failed. Returns only where this process is alone.
  virtual void abort() {}

  bool is_single() const { return size() == 1; }
  bool is_root() const { return rank() == 0; }
};

// auto: where a launcher has started this process, or a script of its; on: always; off: never.
enum class MpiMode { kAuto, kOn, kOff };
inline constexpr std::array kMpiModeNames = {"auto", "on", "off"};
constexpr const auto& names_of(MpiMode) { return kMpiModeNames; }

// The processes that were started together with this one. Throws Error (kUnavailable) if the
// environment or the mode says that there are several, and this process cannot talk to them.
std::unique_ptr<Ranks> join_ranks(MpiMode mode = MpiMode::kAuto);

// Broadcast: gives every rank the bytes of rank 0. All ranks call it, before they do anything else
// together.
Bytes broadcast(Ranks& ranks, Bytes bytes);

}  // namespace engram
