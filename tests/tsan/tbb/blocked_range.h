#pragma once

#include <tbb/threads.h>
