// The contents of results/ that are committed: of each experiment a folder with its log, the tables made from it, and the
// charts that a document shows; a page over all of them; and documents whose figures are filled in from the logs (quotes.h).
// All but the logs is derived, so that one command writes it again and a test finds what differs.
#pragma once

#include "experiments/log/log.h"

#include <functional>
#include <map>
#include <optional>
#include <string>
#include <vector>

namespace etendue {

// The folders below `root`/results that hold a log, by name.
std::vector<std::string> result_folders(const std::string& root);

// The changes since the log before it lie beside a log under this name (changes.h).
inline constexpr const char* changes_file = "changes.tsv";

std::string commit_of(const RunLog& log);  // of its newest part; "?" where it names none

// The standard output of a program that is looked up in PATH; nullopt where it cannot be started or fails. What it says on
// standard error is dropped.
std::optional<std::string> output_of(const std::vector<std::string>& command);

// "unchanged", or "2 commits, the last of 2026-11-24": those after `commit` that touch the paths, which may be git's pathspecs
// from `root`. "not known" without git, without that commit in its history, and of a commit from which the sources differed.
std::string code_since(const std::string& root, const std::string& commit, const std::vector<std::string>& paths);

// Says on the page whether the code that a folder's experiment measures changed since its log.
using CodeSince = std::function<std::string(const std::string& folder, const RunLog& log)>;
CodeSince code_since_in_git(const std::string& root);

// Every file that is derived, by its path from `root`, with its text: tables, charts that README.md or a file of docs/ shows,
// results/README.md, changes.md of each experiment that ran before, and README.md and docs/ with their figures filled in, as
// well as the table of what moved, between <!--moved--> and <!--/moved-->. Throws Error at a log or a marker that cannot be
// read, and at a chart that is shown and that no log gives.
std::map<std::string, std::string> derived_files(const std::string& root, const CodeSince& since);

// The tables, charts and pages of changes that stand below results/ although nothing derives them, by their paths from `root`.
std::vector<std::string> left_over_files(const std::string& root, const std::map<std::string, std::string>& derived);

// The first sentence of an experiment's file that is a question; "" where there is none.
std::string question_of(const std::string& experiment_text);

}  // namespace etendue
