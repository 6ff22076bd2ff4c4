// Every integrator by name. To add one: write its .h/.cpp in a room of its family and a line in registry.cpp.
#pragma once

#include "framework/integrator.h"

#include <span>

namespace etendue {

std::span<const IntegratorEntry> integrators();
// Throws Error with the nearest names.
const IntegratorEntry& find_integrator(const std::string& name, const Location& where);

}  // namespace etendue
