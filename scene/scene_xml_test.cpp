#include "scene/scene_xml.h"

#include <google/protobuf/util/message_differencer.h>
#include <gtest/gtest.h>

#include <string>

#include "scene/annotations.h"
#include "scene/scene.h"

namespace diaphane::scene {
namespace {

using google::protobuf::util::MessageDifferencer;

diaphane::v1::Scene whole_scene() {
  const auto scene = scene_from_json(R"({
    "transferFunction": {"extinctionPerMm": 0.1, "channels": [
      {"name": "bone & \"teeth\" <1>", "opacity": [{"value": -300.5, "opacity": 0}, {"value": 1e3, "opacity": 0.3333333333333333}],
       "diffuse": {"r": 0.9, "g": 0.8, "b": 0.7}, "gloss": 0.25},
      {"name": "blood", "disabled": true, "opacity": [{"value": 1}, {"value": 2, "opacity": 1}]}]},
    "lights": [
      {"name": "key", "cameraLocked": true, "rectangle": {"corner": {"x": 1}, "u": {"x": 1}, "v": {"y": 1}, "radiance": {"r": 3}}},
      {"environment": {"radiance": {"r": 1, "g": 1, "b": 1}}, "intensity": 2}],
    "camera": {"eye": {"y": -500}, "target": {}, "up": {"z": 1}, "verticalFovDegrees": 30},
    "phase": {"g": -0.5}, "shading": {"mode": "HYBRID"}, "bounces": 3,
    "clip": {"boxLow": {"x": -10}, "boxHigh": {"x": 10}, "planes": [{"normal": {"x": 1}}]},
    "slices": {"axial": {"shown": true, "position": 12}, "windowWidth": 400}})");
  EXPECT_TRUE(scene) << scene.error().message;
  return *scene;
}

std::string field_of_error(std::string_view xml) {
  const auto read = preset_from_xml(xml);
  return read ? "none" : read.error().field;
}

std::string wrapped(const std::string& inside, const std::string& attributes = "version=\"1\"") {
  return "<preset xmlns=\"urn:diaphane:preset\" " + attributes + ">" + inside + "</preset>";
}

TEST(PresetXml, RoundTripsExactly) {
  const auto scene = whole_scene();
  ASSERT_TRUE(check_scene(scene, no_pictures));
  const std::string xml = preset_to_xml("Mine & yours", scene);
  const auto read = preset_from_xml(xml);
  ASSERT_TRUE(read) << read.error().message;
  EXPECT_TRUE(MessageDifferencer::Equals(read->scene, scene)) << xml;
  EXPECT_EQ(read->name, "Mine & yours");
  EXPECT_FALSE(read->has_unknown);
  EXPECT_EQ(preset_to_xml("Mine & yours", read->scene), xml);
}

TEST(PresetXml, RoundTripsMarksAndMeasurements) {
  const auto annotations = annotations_from_json(R"({
    "marks": {"items": [
      {"id": 1, "kind": "ARROW", "colour": 3, "text": "Here & <there>", "place": {"x": 0.1}, "tail": {"z": -20}},
      {"id": 2, "kind": "CIRCLE", "place": {}, "tail": {}, "radius": 5.5}]},
    "measurements": {"items": [
      {"kind": "RULER", "plane": "CORONAL", "slice": 7, "points": [{"x": 1}, {"x": 2}]}]}})");
  ASSERT_TRUE(annotations) << annotations.error().message;
  const std::string foreign =
      wrapped("<atlas/><annotations><marks><items><id>9</id><glow/></items></marks></annotations>");
  const std::string xml = preset_to_xml("Mine", whole_scene(), foreign, &*annotations);
  const auto read = preset_from_xml(xml);
  ASSERT_TRUE(read) << read.error().message;
  ASSERT_TRUE(read->annotations);
  EXPECT_TRUE(MessageDifferencer::Equals(*read->annotations, *annotations)) << xml;
  EXPECT_TRUE(MessageDifferencer::Equals(read->scene, whole_scene()));
  EXPECT_NE(xml.find("<atlas"), std::string::npos);
  const std::string bare = preset_to_xml("Mine", whole_scene(), foreign);
  EXPECT_EQ(bare.find("annotations"), std::string::npos) << "without marks, none are kept";
  EXPECT_FALSE(preset_from_xml(bare)->annotations);
  EXPECT_EQ(field_of_error(wrapped("<annotations/><annotations/>")), "annotations");
  EXPECT_EQ(field_of_error(wrapped("<annotations><marks><items><kind>STAR</kind></items></marks>"
                                   "</annotations>")),
            "annotations.marks.items[0].kind");
}

TEST(PresetXml, PreservesUnknownElements) {
  const std::string foreign = wrapped(
      "<!-- of the clinic --><atlas region=\"knee\"><page>7</page></atlas>"
      "<transferFunction><channels tint=\"warm\"><name>a</name><opacity><value>1</value></opacity>"
      "<sheen>0.5</sheen></channels></transferFunction><bounces>2</bounces>",
      "version=\"1\" author=\"somebody\"");
  auto read = preset_from_xml(foreign);
  ASSERT_TRUE(read) << read.error().message;
  EXPECT_TRUE(read->has_unknown);
  EXPECT_EQ(read->scene.bounces(), 2U);
  read->scene.set_bounces(5);
  read->scene.mutable_transfer_function()->add_channels()->set_name("b");
  const std::string again = preset_to_xml("New", read->scene, foreign);
  for (const char* kept : {"of the clinic", "<atlas region=\"knee\">", "<page>7</page>",
                           "<channels tint=\"warm\">", "<sheen>0.5</sheen>", "author=\"somebody\"",
                           "<bounces>5</bounces>", "name=\"New\"", "<name>b</name>"}) {
    EXPECT_NE(again.find(kept), std::string::npos) << kept << " in " << again;
  }
  const auto third = preset_from_xml(again);
  ASSERT_TRUE(third);
  EXPECT_TRUE(MessageDifferencer::Equals(third->scene, read->scene));
  EXPECT_EQ(preset_to_xml("New", third->scene, again), again);
}

TEST(PresetXml, NamesTheInvalidElement) {
  EXPECT_EQ(field_of_error(wrapped("<bounces>many</bounces>")), "bounces");
  EXPECT_EQ(field_of_error(wrapped("<bounces>-1</bounces>")), "bounces");
  EXPECT_EQ(field_of_error(wrapped("<bounces>1</bounces><bounces>2</bounces>")), "bounces");
  EXPECT_EQ(field_of_error(wrapped("<phase><g>nan</g></phase>")), "phase.g");
  EXPECT_EQ(field_of_error(wrapped("<phase><g>0,5</g></phase>")), "phase.g");
  EXPECT_EQ(field_of_error(wrapped("<phase><g><h/></g></phase>")), "phase.g");
  EXPECT_EQ(field_of_error(wrapped("<phase>0.5</phase>")), "phase");
  EXPECT_EQ(field_of_error(wrapped("<shading><mode>MAGIC</mode></shading>")), "shading.mode");
  EXPECT_EQ(field_of_error(wrapped("<lights/><lights><disk/><sphere/></lights>")),
            "lights[1].sphere");
  EXPECT_EQ(field_of_error(wrapped("<lights><environment><texture><picture>AAAA</picture></texture>"
                                   "</environment></lights>")),
            "lights[0].environment.texture.picture");
}

TEST(PresetXml, ReportsUnsupportedVersion) {
  EXPECT_EQ(field_of_error(wrapped("", "version=\"2\"")), "version");
  EXPECT_NE(preset_from_xml(wrapped("", "version=\"2\"")).error().message.find("newer"),
            std::string::npos);
  for (const char* version : {"version=\"0\"", "version=\"\"", "version=\"1.0\"", "",
                              "version=\"99999999999999999999\""}) {
    EXPECT_EQ(field_of_error(wrapped("", version)), "version") << version;
  }
}

TEST(PresetXml, RefusesHostileDocuments) {
  const std::string laughs =
      "<?xml version=\"1.0\"?><!DOCTYPE preset [<!ENTITY a \"ha\"><!ENTITY b \"&a;&a;&a;\">]>" +
      wrapped("<lights><name>&b;</name></lights>");
  const std::string outside = "<!DOCTYPE preset [<!ENTITY f SYSTEM \"file:///etc/passwd\">]>" +
                              wrapped("<lights><name>&f;</name></lights>");
  const std::string remote = "<!DOCTYPE preset SYSTEM \"http://127.0.0.1:1/x.dtd\">" + wrapped("");
  std::string deep, close;
  for (int i = 0; i < 20'000; ++i) {
    deep += "<a>";
    close += "</a>";
  }
  std::string many;
  for (int i = 0; i < 30'000; ++i) many += "<a/>";
  for (const std::string& hostile :
       {laughs, outside, remote, wrapped(deep + close), deep, wrapped(many),
        wrapped(std::string(300'000, ' ')), std::string("\0\0", 2), std::string(), std::string("<"),
        std::string("<?xml-stylesheet href=\"x\"?>") + wrapped(""),
        std::string("\xff\xfe<\0p\0", 6), std::string("<preset version=\"1\"/>"), std::string("{}"),
        wrapped("") + wrapped("<b>")}) {
    EXPECT_EQ(field_of_error(hostile), "preset") << hostile.substr(0, 80);
  }
}

TEST(PresetXml, RefusesInvalidUtf8) {
  const std::string declared = "<?xml version=\"1.0\" comment=\"\xff\"?>";
  for (const std::string& bad :
       {wrapped("", "version=\"1\" name=\"\xe9\""), wrapped("<lights><name>\xff</name></lights>"),
        wrapped("<lights><name>&#xD800;</name></lights>"), wrapped("<atlas page=\"&#x110000;\"/>"),
        wrapped("<!-- \xc0\x80 -->"), declared + wrapped("")}) {
    EXPECT_EQ(field_of_error(bad), "preset") << bad;
  }
  EXPECT_EQ(field_of_error(wrapped("<lights><name>&#x20AC; \xc3\xa9</name></lights>")), "none");
}

TEST(PresetXml, UnknownEntitiesStayText) {
  const auto read = preset_from_xml(wrapped("<lights><name>&file; &amp; &#65;</name></lights>"));
  ASSERT_TRUE(read);
  EXPECT_EQ(read->scene.lights(0).name(), "&file; & A");
}

}  // namespace
}  // namespace diaphane::scene
