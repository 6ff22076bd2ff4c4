// The places where the tests find the program and the project. They stand in one small file, so that no other depends on where
// the project lies.
#pragma once

namespace etendue {

extern const char* const program_path;    // the `etendue` that was built with the tests
extern const char* const project_folder;  // with its slash
extern const char* const fault_library;   // to preload (tests/faults)

}  // namespace etendue
