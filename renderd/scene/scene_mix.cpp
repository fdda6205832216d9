#include "renderd/scene/scene_mix.h"

#include <google/protobuf/descriptor.h>

#include <algorithm>
#include <array>
#include <string_view>

#include "renderd/scene/presets.h"

namespace diaphane::render {
namespace {

namespace v1 = diaphane::v1;
using google::protobuf::FieldDescriptor;
using google::protobuf::Message;
using google::protobuf::Reflection;

/// Fields in which 0 means a choice instead of a number (scene.proto).
constexpr std::array<std::string_view, 5> kZeroIsAKind{"radius", "intensity", "gradient_scale",
                                                       "focal_distance", "orthographic_height"};

bool zero_is_a_kind(const FieldDescriptor& field) {
  return std::find(kZeroIsAKind.begin(), kZeroIsAKind.end(), field.name()) != kZeroIsAKind.end();
}

bool field_equal_in_kind(const Message& a, const Message& b, const FieldDescriptor& field) {
  const Reflection& of = *a.GetReflection();
  const bool is_message = field.cpp_type() == FieldDescriptor::CPPTYPE_MESSAGE;
  if (field.is_repeated()) {
    const int count = of.FieldSize(a, &field);
    if (count != of.FieldSize(b, &field) || !is_message) return false;
    for (int i = 0; i < count; ++i) {
      if (!equal_in_kind(of.GetRepeatedMessage(a, &field, i), of.GetRepeatedMessage(b, &field, i)))
        return false;
    }
    return true;
  }
  if (is_message) {
    const bool there = of.HasField(a, &field);
    if (there != of.HasField(b, &field)) return false;
    return !there || equal_in_kind(of.GetMessage(a, &field), of.GetMessage(b, &field));
  }
  switch (field.cpp_type()) {
    case FieldDescriptor::CPPTYPE_DOUBLE:
      return !zero_is_a_kind(field) ||
             (of.GetDouble(a, &field) == 0) == (of.GetDouble(b, &field) == 0);
    case FieldDescriptor::CPPTYPE_BOOL:
      return of.GetBool(a, &field) == of.GetBool(b, &field);
    case FieldDescriptor::CPPTYPE_ENUM:
      return of.GetEnumValue(a, &field) == of.GetEnumValue(b, &field);
    case FieldDescriptor::CPPTYPE_STRING:
      return of.GetString(a, &field) == of.GetString(b, &field);
    case FieldDescriptor::CPPTYPE_UINT32:
      return of.GetUInt32(a, &field) == of.GetUInt32(b, &field);
    default:
      return false;
  }
}

void mix_into(Message& a, const Message& b, double part);

/// Replaces the field of `a` by the mixture. Both messages must be equal in kind in this field.
void mix_field(Message& a, const Message& b, const FieldDescriptor& field, double part) {
  const Reflection& of = *a.GetReflection();
  if (field.is_repeated()) {
    for (int i = 0; i < of.FieldSize(a, &field); ++i) {
      mix_into(*of.MutableRepeatedMessage(&a, &field, i), of.GetRepeatedMessage(b, &field, i),
               part);
    }
  } else if (field.cpp_type() == FieldDescriptor::CPPTYPE_MESSAGE) {
    if (of.HasField(a, &field)) {
      mix_into(*of.MutableMessage(&a, &field), of.GetMessage(b, &field), part);
    }
  } else if (field.cpp_type() == FieldDescriptor::CPPTYPE_DOUBLE) {
    const double from = of.GetDouble(a, &field), to = of.GetDouble(b, &field);
    // Equal numbers stay bitwise the same.
    if (from != to) of.SetDouble(&a, &field, from * (1 - part) + to * part);
  }
}

void mix_into(Message& a, const Message& b, double part) {
  for (int i = 0; i < a.GetDescriptor()->field_count(); ++i) {
    mix_field(a, b, *a.GetDescriptor()->field(i), part);
  }
}

}  // namespace

bool equal_in_kind(const Message& a, const Message& b) {
  for (int i = 0; i < a.GetDescriptor()->field_count(); ++i) {
    if (!field_equal_in_kind(a, b, *a.GetDescriptor()->field(i))) return false;
  }
  return true;
}

v1::Scene mix_scenes(const v1::Scene& a, const v1::Scene& b, double part) {
  const v1::Scene& nearer = part < 0.5 ? a : b;
  v1::Scene mixed = nearer, from = a;
  for (int i = 0; i < v1::Scene::descriptor()->field_count(); ++i) {
    const FieldDescriptor& field = *v1::Scene::descriptor()->field(i);
    if (field.cpp_type() != FieldDescriptor::CPPTYPE_MESSAGE) continue;
    if (!field_equal_in_kind(a, b, field)) continue;
    v1::Scene::GetReflection()->SwapFields(&mixed, &from, {&field});
    mix_field(mixed, b, field, part);
  }
  return check_scene(mixed) ? mixed : nearer;
}

}  // namespace diaphane::render
