#include "scene/scene_xml.h"

#include <google/protobuf/descriptor.h>
#include <google/protobuf/message.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <map>
#include <pugixml.hpp>
#include <sstream>
#include <vector>

#include "common/try.h"
#include "common/utf8.h"

namespace diaphane::scene {
namespace {

using google::protobuf::FieldDescriptor;
using google::protobuf::Message;
using google::protobuf::Reflection;

constexpr const char* kRoot = "preset";
constexpr const char* kAnnotations = "annotations";
constexpr const char* kNamespace = "urn:diaphane:preset";

tl::unexpected<Error> refused(const std::string& field, const std::string& what) {
  return fail(ErrorCode::kInvalid, field + " " + what, field);
}

std::string_view trimmed(std::string_view text) {
  constexpr std::string_view kBlank = " \t\r\n";
  const std::size_t begin = text.find_first_not_of(kBlank);
  if (begin == std::string_view::npos) return {};
  return text.substr(begin, text.find_last_not_of(kBlank) - begin + 1);
}

/// Returns whether a node is valid UTF-8. A character reference such as &#xD800; can make it
/// invalid.
bool has_utf8_only(const pugi::xml_node& node) {
  if (!is_utf8(node.name()) || !is_utf8(node.value())) return false;
  const auto attributes = node.attributes();
  return std::all_of(attributes.begin(), attributes.end(), [](const pugi::xml_attribute& one) {
    return is_utf8(one.name()) && is_utf8(one.value());
  });
}

/// Refuses a DTD, processing instructions, and documents that are too deep or too large. Not
/// recursive, because the depth is still unknown.
Result<void> check_form(const pugi::xml_document& document) {
  int nodes = 0, depth = 0;
  pugi::xml_node node = document.first_child();
  while (node) {
    if (node.type() == pugi::node_doctype) return refused(kRoot, "must not have a DOCTYPE");
    if (node.type() == pugi::node_pi)
      return refused(kRoot, "must not have processing instructions");
    if (++nodes > kMostXmlNodes) return refused(kRoot, "has too many elements");
    if (!has_utf8_only(node)) return refused(kRoot, "must be UTF-8");
    if (node.first_child()) {
      if (++depth >= kDeepestXml) return refused(kRoot, "is nested too deeply");
      node = node.first_child();
      continue;
    }
    while (node && !node.next_sibling()) {
      node = node.parent();
      --depth;
      if (node == document) return {};
    }
    node = node.next_sibling();
  }
  return {};
}

Result<double> number_in(std::string_view text, const std::string& field) {
  double value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size() || !std::isfinite(value)) {
    return refused(field, "must be a number");
  }
  return value;
}

/// Reads one value of a field that is not a message.
Result<void> read_value(Message& message, const FieldDescriptor& f, const pugi::xml_node& element,
                        const std::string& path) {
  const Reflection& fields = *message.GetReflection();
  for (const pugi::xml_node child : element.children()) {
    if (child.type() == pugi::node_element) return refused(path, "must contain only a value");
  }
  const std::string_view text = trimmed(element.text().get());
  switch (f.cpp_type()) {
    case FieldDescriptor::CPPTYPE_DOUBLE: {
      const auto value = number_in(text, path);
      DIAPHANE_TRY(value);
      fields.SetDouble(&message, &f, *value);
      return {};
    }
    case FieldDescriptor::CPPTYPE_UINT32: {
      std::uint32_t value = 0;
      const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
      if (error != std::errc() || end != text.data() + text.size()) {
        return refused(path, "must be a whole number");
      }
      fields.SetUInt32(&message, &f, value);
      return {};
    }
    case FieldDescriptor::CPPTYPE_BOOL:
      if (text != "true" && text != "false") return refused(path, "must be true or false");
      fields.SetBool(&message, &f, text == "true");
      return {};
    case FieldDescriptor::CPPTYPE_ENUM: {
      const auto* value = f.enum_type()->FindValueByName(std::string(text));
      if (value == nullptr) return refused(path, "is not an allowed value");
      fields.SetEnum(&message, &f, value);
      return {};
    }
    case FieldDescriptor::CPPTYPE_STRING:
      if (f.type() == FieldDescriptor::TYPE_BYTES) {
        return refused(path, "must not be set; a preset does not store light textures");
      }
      // Keeps blanks at both ends of a text.
      fields.SetString(&message, &f, element.text().get());
      return {};
    default:
      return refused(path, "has an unknown type");
  }
}

const FieldDescriptor* field_of(const Message& message, std::string_view name) {
  const auto& descriptor = *message.GetDescriptor();
  for (int i = 0; i < descriptor.field_count(); ++i) {
    if (descriptor.field(i)->json_name() == name) return descriptor.field(i);
  }
  return nullptr;
}

std::string joined(const std::string& path, const std::string& name) {
  return path.empty() ? name : path + "." + name;
}

/// Reads the fields of a message. The recursion is limited by the schema, which has no cycle.
Result<void> read_message(Message& message, const pugi::xml_node& element, const std::string& path,
                          bool& has_unknown) {
  const Reflection& fields = *message.GetReflection();
  std::map<std::string, int> counts;
  for (const pugi::xml_node child : element.children()) {
    if (child.type() == pugi::node_comment) has_unknown = true;
    if ((child.type() == pugi::node_pcdata || child.type() == pugi::node_cdata) &&
        !trimmed(child.value()).empty()) {
      return refused(path.empty() ? kRoot : path, "must contain elements, not text");
    }
    if (child.type() != pugi::node_element) continue;
    const FieldDescriptor* f = field_of(message, child.name());
    if (f == nullptr) {
      has_unknown = true;
      continue;
    }
    if (child.first_attribute()) has_unknown = true;
    const int count = counts[child.name()]++;
    std::string at = joined(path, child.name());
    if (f->is_repeated()) at += "[" + std::to_string(count) + "]";
    if (!f->is_repeated() && count > 0) return refused(at, "must occur only once");
    if (f->cpp_type() != FieldDescriptor::CPPTYPE_MESSAGE) {
      if (auto done = read_value(message, *f, child, at); !done) return done;
      continue;
    }
    if (f->containing_oneof() != nullptr && fields.HasOneof(message, f->containing_oneof())) {
      return refused(at, "must not be combined with another shape");
    }
    Message* part =
        f->is_repeated() ? fields.AddMessage(&message, f) : fields.MutableMessage(&message, f);
    if (auto done = read_message(*part, child, at, has_unknown); !done) return done;
  }
  return {};
}

std::string text_of(double value) {
  char text[32];
  return {text, std::to_chars(text, text + sizeof text, value).ptr};
}

std::string value_of(const Message& message, const FieldDescriptor& f) {
  const Reflection& fields = *message.GetReflection();
  switch (f.cpp_type()) {
    case FieldDescriptor::CPPTYPE_DOUBLE:
      return text_of(fields.GetDouble(message, &f));
    case FieldDescriptor::CPPTYPE_UINT32:
      return std::to_string(fields.GetUInt32(message, &f));
    case FieldDescriptor::CPPTYPE_BOOL:
      return fields.GetBool(message, &f) ? "true" : "false";
    case FieldDescriptor::CPPTYPE_ENUM:
      return fields.GetEnum(message, &f)->name();
    default:
      return fields.GetString(message, &f);
  }
}

/// Returns the n-th child of that name, and creates it after the others if it does not exist.
pugi::xml_node element_of(pugi::xml_node& parent, const std::string& name, int index) {
  for (pugi::xml_node child = parent.child(name.c_str()); child;
       child = child.next_sibling(name.c_str())) {
    if (index-- == 0) return child;
  }
  return parent.append_child(name.c_str());
}

void drop_from(pugi::xml_node& parent, const std::string& name, int first) {
  std::vector<pugi::xml_node> surplus;
  for (pugi::xml_node child = parent.child(name.c_str()); child;
       child = child.next_sibling(name.c_str())) {
    if (first-- <= 0) surplus.push_back(child);
  }
  for (const pugi::xml_node& child : surplus) parent.remove_child(child);
}

void write_message(const Message& message, pugi::xml_node element) {
  const Reflection& fields = *message.GetReflection();
  const auto& descriptor = *message.GetDescriptor();
  for (int i = 0; i < descriptor.field_count(); ++i) {
    const FieldDescriptor& f = *descriptor.field(i);
    const std::string name = f.json_name();
    const int count =
        f.is_repeated() ? fields.FieldSize(message, &f) : (fields.HasField(message, &f) ? 1 : 0);
    drop_from(element, name, count);
    for (int n = 0; n < count; ++n) {
      pugi::xml_node child = element_of(element, name, n);
      if (f.cpp_type() == FieldDescriptor::CPPTYPE_MESSAGE) {
        write_message(f.is_repeated() ? fields.GetRepeatedMessage(message, &f, n)
                                      : fields.GetMessage(message, &f),
                      child);
      } else {
        child.text().set(value_of(message, f).c_str());
      }
    }
  }
}

Result<void> parse(std::string_view xml, pugi::xml_document& document) {
  if (xml.size() > kMostXmlBytes) return refused(kRoot, "must be at most 256 KB");
  if (xml.find('\0') != std::string_view::npos)
    return refused(kRoot, "must not contain null bytes");
  if (!is_utf8(xml)) return refused(kRoot, "must be UTF-8");
  // The parser knows only the five entities of XML and character references, and opens no file. A
  // DOCTYPE is parsed only to refuse it.
  constexpr unsigned kOptions =
      pugi::parse_default | pugi::parse_doctype | pugi::parse_comments | pugi::parse_pi;
  const auto parsed = document.load_buffer(xml.data(), xml.size(), kOptions, pugi::encoding_utf8);
  if (!parsed) return refused(kRoot, std::string("is not valid XML: ") + parsed.description());
  return check_form(document);
}

}  // namespace

Result<XmlPreset> preset_from_xml(std::string_view xml) {
  pugi::xml_document document;
  DIAPHANE_TRY(parse(xml, document));
  pugi::xml_node root = document.document_element();
  if (std::string_view(root.name()) != kRoot ||
      std::string_view(root.attribute("xmlns").value()) != kNamespace) {
    return refused(kRoot, "must be the root element, with xmlns=\"urn:diaphane:preset\"");
  }
  const std::string_view version = root.attribute("version").value();
  int number = 0;
  const auto [end, error] =
      std::from_chars(version.data(), version.data() + version.size(), number);
  if (error != std::errc() || end != version.data() + version.size() || number < 1) {
    return refused("version", "must be a whole number of at least 1");
  }
  if (number > kXmlVersion) {
    return refused("version", "is " + std::to_string(number) +
                                  ", which is newer than this server supports (1)");
  }
  XmlPreset preset;
  preset.name = root.attribute("name").value();
  for (const pugi::xml_attribute& attribute : root.attributes()) {
    const std::string_view name = attribute.name();
    if (name != "xmlns" && name != "version" && name != "name") preset.has_unknown = true;
  }
  if (const pugi::xml_node element = root.child(kAnnotations)) {
    preset.annotations.emplace();
    DIAPHANE_TRY(read_message(*preset.annotations, element, kAnnotations, preset.has_unknown));
    root.remove_child(element);
    if (root.child(kAnnotations)) return refused(kAnnotations, "must occur only once");
  }
  DIAPHANE_TRY(read_message(preset.scene, root, {}, preset.has_unknown));
  return preset;
}

std::string preset_to_xml(std::string_view name, const diaphane::v1::Scene& scene,
                          std::string_view kept, const diaphane::v1::Annotations* annotations) {
  pugi::xml_document document;
  if (kept.empty() || !parse(kept, document) || !document.child(kRoot)) document.reset();
  pugi::xml_node root = document.child(kRoot);
  if (!root) {
    pugi::xml_node declaration = document.append_child(pugi::node_declaration);
    declaration.append_attribute("version") = "1.0";
    declaration.append_attribute("encoding") = "UTF-8";
    root = document.append_child(kRoot);
  }
  const auto set = [&](const char* attribute, const std::string& value) {
    if (!root.attribute(attribute)) root.append_attribute(attribute);
    root.attribute(attribute).set_value(value.c_str());
  };
  set("xmlns", kNamespace);
  set("version", std::to_string(kXmlVersion));
  set("name", std::string(name));
  write_message(scene, root);
  drop_from(root, kAnnotations, annotations != nullptr ? 1 : 0);
  if (annotations != nullptr) write_message(*annotations, element_of(root, kAnnotations, 0));
  std::ostringstream text;
  document.save(text, "  ", pugi::format_default, pugi::encoding_utf8);
  return text.str();
}

}  // namespace diaphane::scene
