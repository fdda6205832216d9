// docs/scenes.md is complete and correct: it contains every field of scene.proto and every scene
// file of the tests, and every example in it is part of a valid scene.
#include <gtest/gtest.h>

#include <cctype>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <set>
#include <string>
#include <vector>

#include "renderd/scene/presets.h"
#include "tests/support/renderd/test_folders.h"
#include "tests/support/renderd/test_scenes.h"

namespace diaphane::render {
namespace {

using google::protobuf::Descriptor;
using google::protobuf::FieldDescriptor;

std::string page() {
  std::ifstream file(std::string(test::kDocs) + "/scenes.md");
  return {std::istreambuf_iterator<char>(file), {}};
}

/// Whether the text contains `name` as a whole word between backticks, dots, `[` or quotes.
bool names(const std::string& text, const std::string& name) {
  const auto letter = [&](std::size_t i) {
    return i < text.size() && (std::isalnum(static_cast<unsigned char>(text[i])) != 0);
  };
  for (std::size_t at = text.find(name); at != std::string::npos; at = text.find(name, at + 1)) {
    const bool begins =
        at > 0 && !letter(at - 1) && std::string("`\".").find(text[at - 1]) != std::string::npos;
    if (begins && !letter(at + name.size())) return true;
  }
  return false;
}

void collect(const Descriptor& message, std::set<const Descriptor*>& seen,
             std::set<std::string>& fields) {
  if (!seen.insert(&message).second) return;
  for (int i = 0; i < message.field_count(); ++i) {
    const FieldDescriptor& field = *message.field(i);
    fields.insert(field.json_name());
    if (field.message_type() != nullptr) collect(*field.message_type(), seen, fields);
    if (field.enum_type() == nullptr) continue;
    for (int k = 0; k < field.enum_type()->value_count(); ++k) {
      fields.insert(field.enum_type()->value(k)->name());
    }
  }
}

TEST(ScenesPage, NamesEveryFieldOfTheContract) {
  const std::string text = page();
  ASSERT_FALSE(text.empty());
  std::set<const Descriptor*> seen;
  std::set<std::string> fields;
  collect(*diaphane::v1::Scene::descriptor(), seen, fields);
  EXPECT_GT(fields.size(), 60u);
  for (const std::string& field : fields) EXPECT_TRUE(names(text, field)) << field;
}

TEST(ScenesPage, ListsEveryTestScene) {
  const std::string text = page();
  for (const auto& entry : std::filesystem::directory_iterator(test::kScenes)) {
    EXPECT_TRUE(names(text, entry.path().filename().string())) << entry.path().filename();
  }
}

TEST(ScenesPage, EveryExampleIsPartOfAValidScene) {
  const std::string text = page();
  const std::string fence = "```json\n";
  int examples = 0;
  for (std::size_t at = text.find(fence); at != std::string::npos; at = text.find(fence, at + 1)) {
    const std::size_t begin = at + fence.size();
    const std::string json = text.substr(begin, text.find("```", begin) - begin);
    const auto part = scene_from_json(json);
    ASSERT_TRUE(part) << json << part.error().message;
    diaphane::v1::Scene scene = test::skull_scene();
    // The example replaces the scene's own fields and is not added to them.
    const auto* reflection = part->GetReflection();
    std::vector<const FieldDescriptor*> given;
    reflection->ListFields(*part, &given);
    for (const auto* field : given) scene.GetReflection()->ClearField(&scene, field);
    scene.MergeFrom(*part);
    const auto checked = check_scene(scene);
    EXPECT_TRUE(checked) << json << checked.error().message;
    ++examples;
  }
  EXPECT_GE(examples, 9);
}

}  // namespace
}  // namespace diaphane::render
