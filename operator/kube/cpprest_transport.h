#pragma once

#include <memory>

#include "operator/kube/access.h"
#include "operator/kube/transport.h"

namespace diaphane::kube {

/// A transport over cpprestsdk. No other file of the operator depends on that library.
std::unique_ptr<Transport> make_cpprest_transport(const Access& access);

}  // namespace diaphane::kube
