// Policies behind servers (docs/policy_servers.md). The Python package speaks to them.
#pragma once

#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "apps/command_line.h"
#include "protocol/io/json.h"

namespace engram::apps {

struct PolicyServer {
  std::string url;                                           // empty: none
  std::vector<std::pair<std::string, std::string>> options;  // names without "--server-", values

  bool given() const { return !url.empty(); }
};

// --policy-server; take gets its value.
Option add_policy_server(const Command& command,
                         const std::function<void(const std::string&)>& take);
// The server's options, which need it; take gets names, as of Python's command line, and values.
void add_server_options(const Command& command, const Option& server,
                        const std::function<void(const std::string&, const std::string&)>& take);

// Its description in results and settings.
Json server_config(const PolicyServer& server);

// A command that implements the protocol of docs/evaluation.md by asking the server; seconds: for
// every answer.
std::string bridge_command(const PolicyServer& server, int seconds);

}  // namespace engram::apps
