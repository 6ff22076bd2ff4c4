// Whether the code that an experiment measures changed since its log was written, as the history in git tells.
#pragma once

#include <optional>
#include <string>
#include <vector>

namespace etendue {

// The standard output of a program that is looked up in PATH; nullopt where it cannot be started or fails. What it says on
// standard error is dropped.
std::optional<std::string> output_of(const std::vector<std::string>& command);

// "unchanged", or "2 commits, the last of 2026-11-24": those after `commit` that touch the paths, which may be git's pathspecs
// from `root`. "not known" without git, without that commit in its history, and of a commit from which the sources differed.
std::string code_since(const std::string& root, const std::string& commit, const std::vector<std::string>& paths);

}  // namespace etendue
