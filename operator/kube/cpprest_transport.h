#pragma once

#include <memory>

#include "operator/kube/access.h"
#include "operator/kube/transport.h"

namespace diaphane::kube {

/// cpprestsdk's client. The only file of the operator that names it.
std::unique_ptr<Transport> make_cpprest_transport(const Access& access);

}  // namespace diaphane::kube
