// Policies behind servers (docs/policy_servers.md), and what commands share with them: chunks that
// are cut, and histories. The Python package speaks to them.
#pragma once

#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "apps/command_line.h"
#include "protocol/io/json.h"

namespace engram::apps {

struct PolicyServer {
  std::string url;                                           // empty: none, or a command
  std::vector<std::pair<std::string, std::string>> options;  // names without "--server-", values

  bool given() const { return !url.empty(); }
};

// Takes an option's name, as of Python's command line, and its value.
using TakeOption = std::function<void(const std::string& name, const std::string& value)>;

// --policy-server; take gets its value.
Option add_policy_server(const Command& command,
                         const std::function<void(const std::string&)>& take);
// The server's options, which need it.
void add_server_options(const Command& command, const Option& server, const TakeOption& take);

// --replan and --history, of servers and of commands.
std::vector<Option> add_chunk_options(const Command& command, const TakeOption& take);

// Its description in results and settings; of the command, if there is no server.
Json server_config(const PolicyServer& server, const std::string& command);

// Adds the options of such a description that the server does not have.
void complete_options(const Json& config, PolicyServer& server);

// A command that implements the protocol of docs/evaluation.md by asking the server, or else the
// command; seconds: for every answer.
std::string bridge_command(const PolicyServer& server, const std::string& command, int seconds);

}  // namespace engram::apps
