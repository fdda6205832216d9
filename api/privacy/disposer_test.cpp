#include "api/privacy/disposer.h"

#include <gmock/gmock.h>

#include "tests/support/api/data_set_fixture.h"
#include "tests/support/api/fake_environment_store.h"
#include "tests/support/api/fake_preset_store.h"
#include "tests/support/api/fake_stills.h"
#include "tests/support/api/temporary_directory.h"

namespace diaphane::api {
namespace {

using namespace std::chrono_literals;
using testing::IsEmpty;

class DisposerTest : public DataSetFixture {
 protected:
  void queue(Disposal::Kind kind, const std::string& of) {
    data_set_store.due.push_back({kind, of});
  }

  const TemporaryDirectory disk;
  UploadFiles files{disk.path()};
  FakeStills stills;
  FakePresetStore preset_store;
  Presets presets{data_sets, preset_store, clock, signals};
  Thumbnails thumbnails{data_sets, stills, disk.path()};
  PresetPictures pictures{
      data_sets, presets, preset_store, stills, clock, disk.path(), [](const std::string& scene) {
        return scene;
      }};
  FakeEnvironmentStore environment_store;
  FakeImporter importer;
  Environments environments{environment_store, importer, clock, signals, disk.path() + "/volumes"};
  Disposer disposer{
      data_set_store,          files, thumbnails, pictures, environments, disk.path() + "/volumes",
      disk.path() + "/exports"};
};

TEST_F(DisposerTest, EachKindOfDataIsDeletedWithAllItsFilesAndNoOthers) {
  struct Case {
    Disposal::Kind kind;
    std::vector<std::string> deleted;
  };
  const std::string upload = id + ".tar", volume = "volumes/" + id + "/voxels.i16",
                    thumbnail = "thumbnails/" + id + "/bone.jpg",
                    archive = "exports/" + id + ".zip", preset = "presets/" + id + "/picture.jpg",
                    environment = "volumes/environments/" + id + ".hdr",
                    scan = "exports/" + id + ".scan";
  const std::vector<std::string> all{upload, volume, thumbnail, archive, preset, environment, scan};
  for (const Case& one :
       {Case{Disposal::Kind::kUpload, {upload}}, Case{Disposal::Kind::kVolume, {volume, thumbnail}},
        Case{Disposal::Kind::kPictures, {thumbnail}}, Case{Disposal::Kind::kExport, {archive}},
        Case{Disposal::Kind::kPreset, {preset}}, Case{Disposal::Kind::kScanExport, {scan}},
        Case{Disposal::Kind::kEnvironment, {environment}}}) {
    for (const std::string& file : all) disk.write(file, "data");
    queue(one.kind, id);
    EXPECT_EQ(disposer.dispose(), 1);
    EXPECT_THAT(data_set_store.due, IsEmpty());
    for (const std::string& file : all) {
      const bool deleted =
          std::find(one.deleted.begin(), one.deleted.end(), file) != one.deleted.end();
      EXPECT_EQ(disk.has(file), !deleted) << file;
    }
  }
}

TEST_F(DisposerTest, MissingFilesAreNotAnError) {
  for (const auto kind :
       {Disposal::Kind::kUpload, Disposal::Kind::kVolume, Disposal::Kind::kPictures,
        Disposal::Kind::kExport, Disposal::Kind::kPreset, Disposal::Kind::kScanExport}) {
    queue(kind, new_id());
  }
  EXPECT_EQ(disposer.dispose(), 6);
  EXPECT_THAT(data_set_store.due, IsEmpty());
}

TEST_F(DisposerTest, FailedDeletionStaysQueuedWithoutBlockingOthers) {
  const std::string stuck = new_id();
  disk.write("exports/" + stuck + ".zip/file", "a directory where the file belongs");
  queue(Disposal::Kind::kExport, stuck);
  queue(Disposal::Kind::kVolume, "../volumes");
  queue(Disposal::Kind::kUpload, id);
  disk.write("volumes/a", "kept");
  EXPECT_EQ(disposer.dispose(), 1);
  EXPECT_EQ(data_set_store.due.size(), 2u);
  EXPECT_TRUE(disk.has("volumes/a")) << "an ID that is a path is never followed";
  std::filesystem::remove_all(disk.path() + "/exports");
  EXPECT_EQ(disposer.dispose(), 1);
}

TEST_F(DisposerTest, WithoutTheDatabaseNothingIsCountedAsDeleted) {
  queue(Disposal::Kind::kUpload, id);
  data_set_store.break_function("disposed");
  EXPECT_EQ(disposer.dispose(), 0);
  data_set_store.break_function("disposals");
  EXPECT_EQ(disposer.dispose(), 0);
  EXPECT_EQ(data_set_store.due.size(), 1u);
}

}  // namespace
}  // namespace diaphane::api
