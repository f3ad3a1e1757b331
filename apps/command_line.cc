#include "apps/command_line.h"

#include <CLI/CLI.hpp>
#include <string>
#include <vector>

#include "core/base/nearest.h"
#include "protocol/make/make.h"

namespace engram::apps {

// --- options ---

const Option& Option::type_name(const std::string& name) const {
  option_->type_name(name);
  return *this;
}

const Option& Option::default_str(const std::string& value) const {
  option_->default_str(value);
  return *this;
}

const Option& Option::description(const std::string& text) const {
  option_->description(text);
  return *this;
}

const Option& Option::required() const {
  option_->required();
  return *this;
}

const Option& Option::excludes(const Option& other) const {
  option_->excludes(other.option_);
  return *this;
}

const Option& Option::needs(const Option& other) const {
  option_->needs(other.option_);
  return *this;
}

void Option::need_no_longer(const Option& other) const { option_->remove_needs(other.option_); }

// --- commands ---

namespace {

constexpr const char* kHidden = "hidden";

// Writes all groups of options but that one.
class HelpWithoutHidden final : public CLI::Formatter {
 public:
  std::string make_group(std::string group, bool is_positional,
                         std::vector<const CLI::Option*> options) const override {
    if (group == kHidden) return {};
    return CLI::Formatter::make_group(std::move(group), is_positional, std::move(options));
  }
};

void refuse_empty(const std::string& name, const std::string& value) {
  if (value.empty()) throw Error(Error::kInvalidArgument, name + ": '' given, a text needed");
}

}  // namespace

Command Command::add_command(const std::string& name, const std::string& description) const {
  return Command(app_->add_subcommand(name, description));
}

Option Command::add_option(const std::string& name, std::string& value,
                           const std::string& help) const {
  const auto take = [name, &value](const std::string& text) {
    refuse_empty(name, text);
    value = text;
  };
  return Option(app_->add_option_function<std::string>(name, take, help));
}

Option Command::add_option(const std::string& name, std::vector<std::string>& values,
                           const std::string& help) const {
  const auto take = [name, &values](const std::vector<std::string>& texts) {
    for (const std::string& text : texts) refuse_empty(name, text);
    values = texts;
  };
  return Option(app_->add_option_function<std::vector<std::string>>(name, take, help));
}

Option Command::add_option(const std::string& name,
                           const std::function<void(const std::string&)>& take,
                           const std::string& help) const {
  return Option(app_->add_option_function<std::string>(name, take, help));
}

Option Command::add_repeatable(const std::string& name,
                               std::function<void(const std::string&)> take,
                               const std::string& help) const {
  const auto take_all = [take = std::move(take)](const std::vector<std::string>& values) {
    for (const std::string& value : values) take(value);
  };
  CLI::Option* option = app_->add_option_function<std::vector<std::string>>(name, take_all, help);
  return Option(option->allow_extra_args(false));
}

Option Command::add_positive(const std::string& name, double& value,
                             const std::string& help) const {
  CLI::Option* option = app_->add_option(name, value, help);
  return Option(option->check(CLI::PositiveNumber)->capture_default_str());
}

Option Command::add_flag(const std::string& name, bool& value, const std::string& help) const {
  return Option(app_->add_flag(name, value, help));
}

Option Command::add_flag(const std::string& name, std::function<void()> take,
                         const std::string& help) const {
  return Option(app_->add_flag_callback(name, std::move(take), help));
}

void Command::remove_option(const std::string& name) const {
  app_->remove_option(app_->get_option(name));
}

// An option without a group would be hidden, too, but has no name in messages.
void Command::hide_option(const std::string& name) const {
  CLI::Option* hidden = app_->get_option(name);
  hidden->group(kHidden);
  // The help of others would name it; what it excludes it refuses by itself.
  for (CLI::Option* other : app_->get_options()) (void)other->remove_excludes(hidden);
  app_->formatter(std::make_shared<HelpWithoutHidden>());
}

bool Command::given(const std::string& name) const {
  const CLI::Option* option = app_->get_option_no_throw(name);
  return option != nullptr && option->count() > 0;
}

std::vector<std::string> Command::values(const std::string& name) const {
  return given(name) ? app_->get_option_no_throw(name)->results() : std::vector<std::string>();
}

void Command::share_options() const { app_->fallthrough(); }

void Command::footer(const std::string& text) const { app_->footer(text); }

void Command::when_parsed(std::function<void()> call) const {
  app_->parse_complete_callback(std::move(call));
}

void Command::on_run(std::function<void()> run) const { app_->final_callback(std::move(run)); }

// --- the whole line ---

namespace {

// The command or option that a word is a misspelling of, as a question; empty if there is none.
std::string suggestion(const CLI::App& app, const std::string& word) {
  constexpr std::size_t kMaxEdits = 3;
  std::vector<std::string> names;
  if (word.starts_with("-")) {
    const CLI::App* deepest = &app;
    while (!deepest->get_subcommands().empty()) deepest = deepest->get_subcommands().front();
    for (const CLI::Option* option : deepest->get_options()) {
      if (option->get_group() == kHidden) continue;
      for (const std::string& name : option->get_lnames()) names.push_back("--" + name);
    }
  } else if (app.get_subcommands().empty()) {
    const auto all = [](const CLI::App* /*command*/) { return true; };
    for (const CLI::App* command : app.get_subcommands(all)) names.push_back(command->get_name());
  }
  const std::string near = nearest(names, word);
  const bool is_near = !near.empty() && edit_distance(near, word) <= kMaxEdits &&
                       edit_distance(near, word) < word.size();
  return is_near ? "did you mean '" + near + "'? " : "";
}

// The parser's refusal, in words of our own where its message is too short.
std::string explain(const CLI::App& app, const CLI::ParseError& error) {
  std::string what = error.what();
  std::string program = app.get_name();
  std::string meant;
  for (const CLI::App* command : app.get_subcommands()) program += " " + command->get_name();
  const std::vector<std::string> unexpected = app.remaining(true);
  if (!unexpected.empty()) {
    what = app.get_subcommands().empty() ? "no command" : "unexpected";
    for (const std::string& argument : unexpected) what += " '" + argument + "'";
    meant = suggestion(app, unexpected.front());
  } else if (app.get_subcommands().empty()) {
    what = "no command given";
  }
  return what + "; " + meant + "`" + program + " --help` shows what is allowed";
}

// CLI11 takes the next word for the value of `--name=`.
void refuse_without_value(const std::vector<std::string>& words) {
  for (const std::string& word : words) {
    if (!word.starts_with("--") || word.find('=') != word.size() - 1) continue;
    refuse_empty(word.substr(0, word.size() - 1), "");
  }
}

// Calls `parse`, which has CLI11 read the words.
template <class Parse>
std::string parse_safely(const CLI::App& app, const Parse& parse) {
  try {
    parse();
  } catch (const CLI::CallForHelp&) {
    return app.help();
  } catch (const CLI::CallForVersion& version) {
    return std::string(version.what()) + "\n";
  } catch (const CLI::ParseError& error) {
    throw Error(Error::kInvalidArgument, explain(app, error));
  }
  return {};
}

}  // namespace

CommandLine::CommandLine(const std::string& name, const std::string& description)
    : app_(std::make_unique<CLI::App>(description, name)) {}

CommandLine::~CommandLine() = default;

void CommandLine::set_version(const std::string& version) {
  app_->set_version_flag("--version", version);
}

void CommandLine::require_command() { app_->require_subcommand(1); }

std::string CommandLine::parse(int argc, const char* const* argv) {
  refuse_without_value({argv, argv + argc});
  return parse_safely(*app_, [&] { app_->parse(argc, argv); });
}

std::string CommandLine::parse(const std::vector<std::string>& words) {
  refuse_without_value(words);
  return parse_safely(*app_, [&] {
    app_->parse(std::vector<std::string>(words.rbegin(), words.rend()));  // the last one first
  });
}

}  // namespace engram::apps
