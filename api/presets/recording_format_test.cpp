#include "api/presets/recording_format.h"

#include <gtest/gtest.h>

namespace diaphane::api {
namespace {

using nlohmann::json;

json sound() {
  return json::parse(R"({
    "format": "diaphane-interaction", "version": 1, "viewport": {"width": 640, "height": 480},
    "events": [
      {"at_ms": 0, "scene": {"transferFunction": {"channels": [
          {"name": "Mrs Example", "diffuse": {"r": 0.5}, "opacity": [{"value": 100, "opacity": 1}]}]},
        "lights": [{"name": "typed", "environment": {"texture": {"picture": "AAAA"}}}],
        "camera": {"projection": "ORTHOGRAPHIC"}}},
      {"at_ms": 16, "camera": {"eye": {"x": 2}}}]})");
}

struct ReadRecording {
  Recording recording;
  std::optional<Problem> wrong;
};

ReadRecording read(const json& document) {
  Request request;
  request.headers["content-type"] = "application/json";
  request.body = document.dump();
  Fields in(request, kMostRecordingValues);
  ReadRecording read;
  read.recording = read_recording(in);
  read.wrong = in.finish();
  return read;
}

TEST(RecordingFormat, KeepsViewSettingsAndDropsFreeText) {
  const auto kept = read(sound());
  ASSERT_FALSE(kept.wrong);
  EXPECT_EQ(kept.recording.events, 2);
  EXPECT_EQ(kept.recording.duration_ms, 16);
  const json body = json::parse(kept.recording.body);
  EXPECT_EQ(body["events"][1], sound()["events"][1]);
  EXPECT_EQ(body["events"][0]["scene"]["transferFunction"]["channels"][0]["diffuse"]["r"], 0.5);
  EXPECT_EQ(body["events"][0]["scene"]["camera"]["projection"], "ORTHOGRAPHIC");
  for (const char* typed : {"Mrs", "typed", "AAAA", "name"}) {
    EXPECT_EQ(kept.recording.body.find(typed), std::string::npos) << typed;
  }
  // The stored form can be sent again.
  EXPECT_EQ(read(body).recording.body, kept.recording.body);
}

TEST(RecordingFormat, NamesTheInvalidFieldOfAMalformedRecording) {
  const auto refused = [](const char* patch) {
    const auto got = read(sound().patch(json::parse(patch)));
    return got.wrong && !got.wrong->fields.empty() ? got.wrong->fields.front().field : "";
  };
  for (const char* patch : {
           R"([{"op": "replace", "path": "/events", "value": []}])",
           R"([{"op": "replace", "path": "/events/0/at_ms", "value": 1}])",
           R"([{"op": "replace", "path": "/events/1/at_ms", "value": -1}])",
           R"([{"op": "replace", "path": "/events/1/at_ms", "value": 10001}])",
           R"([{"op": "replace", "path": "/events/1/at_ms", "value": 1.5}])",
           R"([{"op": "replace", "path": "/events/1/at_ms", "value": 18446744073709551615}])",
           R"([{"op": "remove", "path": "/events/0"}])",
           R"([{"op": "add", "path": "/events/1/scene", "value": {}}])",
           R"([{"op": "add", "path": "/events/1/user", "value": "Ann"}])",
           R"([{"op": "replace", "path": "/events/1/camera", "value": []}])",
           R"([{"op": "add", "path": "/events/1/camera/note", "value": "of Ann"}])",
       }) {
    EXPECT_EQ(refused(patch), "events") << patch;
  }
  EXPECT_EQ(refused(R"([{"op": "replace", "path": "/version", "value": 2}])"), "version");
  EXPECT_EQ(refused(R"([{"op": "replace", "path": "/format", "value": "x"}])"), "format");
  EXPECT_EQ(refused(R"([{"op": "replace", "path": "/viewport/width", "value": 5}])"), "viewport");
  EXPECT_EQ(refused(R"([{"op": "add", "path": "/title", "value": "Head"}])"), "title");
}

TEST(RecordingFormat, LimitsSizeOfStoredFormToOneMebibyte) {
  // Three characters of the request become twelve in the stored form: "1e9" is written as
  // 1000000000.0.
  const auto recorded = [](int numbers) {
    std::string list = "1e9";
    for (int i = 1; i < numbers; ++i) list += ",1e9";
    Request request;
    request.headers["content-type"] = "application/json";
    request.body = R"({"format": "diaphane-interaction", "version": 1,
        "viewport": {"width": 640, "height": 480},
        "events": [{"at_ms": 0, "scene": {}}, {"at_ms": 1, "camera": {"eye": [)" +
                   list + "]}}]}";
    Fields in(request, kMostRecordingValues);
    ReadRecording read;
    read.recording = read_recording(in);
    read.wrong = in.finish();
    return read;
  };
  const auto large = recorded(80'000);
  ASSERT_FALSE(large.wrong);
  EXPECT_GT(large.recording.body.size(), 1'040'000U);
  EXPECT_LE(large.recording.body.size(), 1'048'576U);
  const auto too_large = recorded(100'000);
  ASSERT_TRUE(too_large.wrong);
  EXPECT_EQ(too_large.wrong->kind, ProblemKind::kInvalid);
  EXPECT_EQ(too_large.wrong->fields.at(0).field, "events");
  EXPECT_NE(too_large.wrong->fields.at(0).message.find("1 MiB"), std::string::npos);
}

TEST(RecordingFormat, RefusesNestingDeeperThanAScene) {
  json deep = json::object();
  for (int i = 0; i < 50; ++i) deep = json{{"a", deep}};
  json document = sound();
  document["events"][1]["camera"] = deep;
  EXPECT_TRUE(read(document).wrong);
}

}  // namespace
}  // namespace diaphane::api
