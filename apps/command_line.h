// Commands and their options. CLI11 parses them; its headers are hidden because they take longer to
// compile than everything else that a command includes.
#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

namespace CLI {  // NOLINT(readability-identifier-naming): a library's
class App;
class Option;
}  // namespace CLI

namespace engram::apps {

// An option or argument of a command. Help shows `--name TYPE=DEFAULT  description`.
class Option {
 public:
  explicit Option(CLI::Option* option) : option_(option) {}

  const Option& type_name(const std::string& name) const;
  const Option& default_str(const std::string& value) const;
  const Option& description(const std::string& text) const;
  const Option& required() const;
  const Option& excludes(const Option& other) const;
  const Option& needs(const Option& other) const;
  // Takes back what `needs` has asked for; may be called while options are read.
  void need_no_longer(const Option& other) const;

 private:
  CLI::Option* option_;  // of the CommandLine
};

// A command, or the program as a whole.
class Command {
 public:
  explicit Command(CLI::App* app) : app_(app) {}

  Command add_command(const std::string& name, const std::string& description) const;

  // Names without dashes are those of arguments. An empty text is refused: it comes from a variable
  // that is not set, and is never what was meant.
  Option add_option(const std::string& name, std::string& value, const std::string& help) const;
  // One value or more.
  Option add_option(const std::string& name, std::vector<std::string>& values,
                    const std::string& help) const;
  // `take` gets the value as soon as it is read; what it throws ends the parsing.
  Option add_option(const std::string& name, const std::function<void(const std::string&)>& take,
                    const std::string& help) const;
  // The option may be given several times; `take` gets one value after the other.
  Option add_repeatable(const std::string& name, std::function<void(const std::string&)> take,
                        const std::string& help) const;
  // A number above 0; the default is what it holds.
  Option add_positive(const std::string& name, double& value, const std::string& help) const;
  Option add_flag(const std::string& name, bool& value, const std::string& help) const;
  Option add_flag(const std::string& name, std::function<void()> take,
                  const std::string& help) const;
  void remove_option(const std::string& name) const;
  // Still read, for what the command says of it, but no part of the help.
  void hide_option(const std::string& name) const;
  // True if the user has given the option; false if there is no such option.
  bool given(const std::string& name) const;
  // What the user has given to it, as text.
  std::vector<std::string> values(const std::string& name) const;

  // Allows the option of this command behind the words of its subcommands, too.
  void share_options() const;
  // Text at the end of the help.
  void footer(const std::string& text) const;
  // Called when the command's words are read, before it runs.
  void when_parsed(std::function<void()> call) const;
  // Sets the function of the command.
  void on_run(std::function<void()> run) const;

 private:
  CLI::App* app_;  // of the CommandLine
};

class CommandLine {
 public:
  CommandLine(const std::string& name, const std::string& description);
  ~CommandLine();
  CommandLine(const CommandLine&) = delete;
  CommandLine& operator=(const CommandLine&) = delete;

  Command program() const { return Command(app_.get()); }
  void set_version(const std::string& version);
  void require_command();

  // Reads the words and runs the command that they name. Returns the text that the user asks for
  // instead, help or version. Throws Error if the words are not allowed, and what the command
  // throws.
  std::string parse(int argc, const char* const* argv);
  // Parses words without the program's name.
  std::string parse(const std::vector<std::string>& words);

 private:
  std::unique_ptr<CLI::App> app_;
};

}  // namespace engram::apps
