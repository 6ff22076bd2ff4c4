#include "tests/places.h"

namespace etendue {

const char* const program_path = ETENDUE_EXECUTABLE;
const char* const fault_library = ETENDUE_FAULT_LIBRARY;
const char* const project_folder = ETENDUE_SOURCE_DIR "/";

}  // namespace etendue
