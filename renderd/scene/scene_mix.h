#pragma once

#include "api/proto/scene.pb.h"

namespace diaphane::render {

/// Whether numbers are all that two messages differ in: the same fields, lists as long, the same
/// names, choices and pictures. Where 0 means "none" or "the usual", both or neither are 0.
bool equal_in_kind(const google::protobuf::Message& a, const google::protobuf::Message& b);

/// `part` of the way from `a` to `b`, for each part of the scene that is equal in kind; the others
/// are the nearer one's. Where the mixture would be no sound scene, all of it is.
diaphane::v1::Scene mix_scenes(const diaphane::v1::Scene& a, const diaphane::v1::Scene& b,
                               double part);

}  // namespace diaphane::render
