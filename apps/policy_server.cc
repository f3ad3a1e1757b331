#include "apps/policy_server.h"

#include <algorithm>
#include <array>
#include <string_view>

#include "apps/python_module.h"
#include "core/base/error.h"

namespace engram::apps {
namespace {

struct ServerOption {
  const char* name;
  const char* type;
  const char* help;
};

// Values are checked in Python (python/engram/servers/options.py).
constexpr std::array<ServerOption, 6> kServerOptions = {{
    {"--server-keys", "NAME|FILE.json",
     "Names of images, state and instruction: mikasa (default), libero, droid, openvla, oft"},
    {"--server-state", "LAYOUT",
     "Numbers of the state: tcp7, tcp7_continuous, libero8, libero_rpy8, oxe8 or joints8; default: "
     "the keys' own"},
    {"--server-actions", "NAME",
     "What its actions mean: mikasa, libero or oxe; default: the keys' own"},
    {"--server-image", "N|HxW|native",
     "Size of the images that it gets; default: the server's or the keys' own"},
    {"--server-reset", "reconnect|message|none",
     "How it learns of a new episode; default: as usual for the protocol"},
    {"--server-wait", "SECONDS", "Time that it may take until it listens; default: 10"},
}};
constexpr std::array<ServerOption, 2> kChunkOptions = {{
    {"--replan", "N",
     "Actions of a chunk that are used before the policy is asked again; default: all"},
    {"--history", "last|since-last|N,STRIDE",
     "Frames that the policy gets: the last (default), all since the last question, or N at a "
     "stride"},
}};

// "keys" of --server-keys, "replan" of --replan.
std::string key_of_option(const std::string& name) {
  constexpr std::string_view kPrefix = "--server-";
  return name.substr(name.starts_with(kPrefix) ? kPrefix.size() : 2);
}

Option add_one(const Command& command, const ServerOption& option, const TakeOption& take) {
  const std::string name = option.name;
  return command
      .add_option(
          name, [take, name](const std::string& value) { take(name, value); }, option.help)
      .type_name(option.type);
}

}  // namespace

Option add_policy_server(const Command& command,
                         const std::function<void(const std::string&)>& take) {
  const auto take_text = [take](const std::string& value) {
    if (value.empty()) {
      throw Error(Error::kInvalidArgument, "--policy-server: '' given, a text needed");
    }
    take(value);
  };
  return command
      .add_option("--policy-server", take_text,
                  "A policy server: openpi|gr00t|act|vla-eval://HOST:PORT "
                  "(docs/policy_servers.md)")
      .type_name("URL");
}

void add_server_options(const Command& command, const Option& server, const TakeOption& take) {
  for (const ServerOption& option : kServerOptions) add_one(command, option, take).needs(server);
}

std::vector<Option> add_chunk_options(const Command& command, const TakeOption& take) {
  std::vector<Option> options;
  for (const ServerOption& option : kChunkOptions) {
    options.push_back(add_one(command, option, take));
  }
  return options;
}

Json server_config(const PolicyServer& server, const std::string& command) {
  JsonTable config{server.given() ? std::pair<std::string, Json>("server", server.url)
                                  : std::pair<std::string, Json>("command", command)};
  for (const auto& [name, value] : server.options) {
    config.emplace_back(key_of_option(name), value);
  }
  return config;
}

void complete_options(const Json& config, PolicyServer& server) {
  const auto add = [&](const ServerOption& option) {
    const std::string name = option.name;
    const Json* value = find(config, key_of_option(name));
    const auto is_it = [&name](const auto& given) { return given.first == name; };
    if (value != nullptr && std::ranges::none_of(server.options, is_it)) {
      server.options.emplace_back(name, text(*value));
    }
  };
  std::ranges::for_each(kServerOptions, add);
  std::ranges::for_each(kChunkOptions, add);
}

std::string bridge_command(const PolicyServer& server, const std::string& command, int seconds) {
  const bool served = server.given();
  std::vector<std::string> words =
      python_words("engram.servers", served ? "--policy-server" : "--replan, --history");
  words.insert(words.end(), {"bridge", served ? server.url : "--command=" + command,
                             "--timeout=" + std::to_string(seconds)});
  for (const auto& [name, value] : server.options) words.push_back(name + "=" + value);
  return shell_command(words);
}

}  // namespace engram::apps
