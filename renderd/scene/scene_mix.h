#pragma once

#include "api/proto/scene.pb.h"

namespace diaphane::render {

/// Returns whether two messages differ only in numbers: they have the same fields, lists of equal
/// lengths, and the same names, choices and pictures. A number where 0 means "none" or "the usual"
/// is 0 in both or in neither.
bool equal_in_kind(const google::protobuf::Message& a, const google::protobuf::Message& b);

/// Interpolates each part of the scene that is equal in kind; `part` is 0 at `a` and 1 at `b`. All
/// other parts are those of the nearer scene. If the mixture is not a valid scene, the result is
/// the nearer scene.
diaphane::v1::Scene mix_scenes(const diaphane::v1::Scene& a, const diaphane::v1::Scene& b,
                               double part);

}  // namespace diaphane::render
