#pragma once
/// How --help reads, for all tools: values by their type (FILE, LENGTH, WxH), lines wrapped to the terminal, results and
/// general options in groups of their own.
#include <functional>
#include <string>
#include <vector>

namespace CLI {
class App;
}

namespace procam::tools {

/// Of a tool whose options are declared. An option of text without an entry in the table of help.cpp keeps "TEXT"; a test
/// finds it.
void arrange_help(CLI::App& app);

/// The options that `declare` adds are listed under `title`.
void declare_group(CLI::App& app, const std::string& title, const std::function<void()>& declare);

/// Words of `text` in lines of at most `width` letters; a longer word has a line of its own. Lines after the first begin
/// with `indent` blanks, and the first has `used` letters already. Line breaks of the text stay, and
/// lines that begin with two blanks (commands) are not wrapped.
std::string wrapped(const std::string& text, std::size_t width, std::size_t indent, std::size_t used);

/// The files and folders that the command line names, as input or as results, in the order of the options.
enum class NamedFiles { kInputs, kResults };
std::vector<std::string> named_files(const CLI::App& app, NamedFiles which);

/// The options' long names ("--rig") that may have been meant by one that is not known; empty when none is near.
std::string nearest_option(const CLI::App& app, const std::string& typed);

}  // namespace procam::tools
