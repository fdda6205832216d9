#include "renderd/session/volume_cache.h"

#include <gtest/gtest.h>

#include <atomic>
#include <future>
#include <latch>
#include <map>
#include <set>
#include <thread>

namespace diaphane::render {
namespace {

std::vector<std::string> ids_of(const std::vector<VolumeCache::Outdated>& volumes) {
  std::vector<std::string> ids;
  for (const auto& volume : volumes) ids.push_back(volume.id);
  return ids;
}

class FakeVolume final : public DeviceVolume {
 public:
  explicit FakeVolume(std::uint64_t bytes, std::string hash = {}) : bytes_(bytes) {
    header_.content_hash = std::move(hash);
  }
  const volume::Header& header() const override { return header_; }
  std::uint64_t device_bytes() const override { return bytes_; }

 private:
  volume::Header header_;
  std::uint64_t bytes_;
};

using Handle = VolumeCache::Handle;

Result<Handle> wait_for(VolumeCache& cache, const std::string& id) {
  std::promise<Result<Handle>> promise;
  cache.get({id}, [&](Result<Handle> volume) { promise.set_value(std::move(volume)); });
  return promise.get_future().get();
}

Result<Handle> hundred_bytes(const VolumeKey&) { return Handle(std::make_shared<FakeVolume>(100)); }

TEST(VolumeCache, LoadsVolumeOnceForConcurrentRequests) {
  std::atomic<int> loads{0};
  std::latch asked(1);
  VolumeCache cache(
      [&](const VolumeKey& key) {
        asked.wait();
        ++loads;
        return hundred_bytes(key);
      },
      1000, 3);
  std::vector<std::future<Result<Handle>>> futures;
  for (int i = 0; i < 20; ++i) {
    auto promise = std::make_shared<std::promise<Result<Handle>>>();
    futures.push_back(promise->get_future());
    cache.get({"a"}, [promise](Result<Handle> volume) { promise->set_value(std::move(volume)); });
  }
  asked.count_down();
  std::set<const DeviceVolume*> different;
  for (auto& future : futures) different.insert(future.get()->get());
  EXPECT_EQ(loads, 1);
  EXPECT_EQ(different.size(), 1U);
  EXPECT_EQ(cache.bytes(), 100U);
}

TEST(VolumeCache, EvictsTheLeastRecentlyUsedUnreferencedVolume) {
  VolumeCache cache(hundred_bytes, 300);
  wait_for(cache, "a");
  wait_for(cache, "b");
  wait_for(cache, "c");
  wait_for(cache, "a");  // b is now the oldest
  const auto held = wait_for(cache, "c");
  wait_for(cache, "d");
  EXPECT_EQ(cache.loaded(), (std::vector<std::string>{"a", "c", "d"}));
  wait_for(cache, "e");  // a is evicted, c is in use
  wait_for(cache, "f");
  EXPECT_EQ(cache.loaded(), (std::vector<std::string>{"c", "e", "f"}));
  EXPECT_EQ(cache.bytes(), 300U);
}

TEST(VolumeCache, RefusesVolumeThatDoesNotFitBesideReferencedOnes) {
  VolumeCache cache(hundred_bytes, 250);
  auto a = wait_for(cache, "a");
  auto b = wait_for(cache, "b");
  const auto c = wait_for(cache, "c");
  ASSERT_FALSE(c);
  EXPECT_EQ(c.error().code, ErrorCode::kOutOfMemory);
  EXPECT_EQ(cache.bytes(), 200U);
  a->reset();
  EXPECT_TRUE(wait_for(cache, "c"));
  EXPECT_EQ(cache.loaded(), (std::vector<std::string>{"b", "c"}));
}

TEST(VolumeCache, ReportsFailureAndRetriesTheNextTime) {
  std::atomic<bool> broken{true};
  VolumeCache cache(
      [&](const VolumeKey& key) -> Result<Handle> {
        if (broken) return fail(ErrorCode::kNotFound, "no such volume");
        return hundred_bytes(key);
      },
      1000);
  EXPECT_EQ(wait_for(cache, "a").error().code, ErrorCode::kNotFound);
  broken = false;
  EXPECT_TRUE(wait_for(cache, "a"));
}

TEST(VolumeCache, OutOfMemoryIsAnError) {
  VolumeCache cache([](const VolumeKey&) -> Result<Handle> { throw std::bad_alloc(); }, 1000);
  EXPECT_EQ(wait_for(cache, "a").error().code, ErrorCode::kOutOfMemory);
}

TEST(VolumeCache, DestructorAnswersWaitingRequests) {
  std::promise<void> release;
  std::atomic<int> answered{0};
  {
    auto cache = std::make_unique<VolumeCache>(
        [&](const VolumeKey& key) {
          release.get_future().wait();
          return hundred_bytes(key);
        },
        1000);
    for (const char* id : {"a", "b", "c"}) cache->get({id}, [&](Result<Handle>) { ++answered; });
    std::thread later([&] {
      std::this_thread::sleep_for(std::chrono::milliseconds(20));
      release.set_value();
    });
    cache.reset();
    later.join();
  }
  EXPECT_EQ(answered, 3);
}

/// A store in which volumes can be replaced and deleted.
struct FakeStore {
  std::map<std::string, std::string> hashes{{"a", "old"}, {"b", "other"}};
  VolumeCache::Load load = [this](const VolumeKey& key) -> Result<Handle> {
    return Handle(std::make_shared<FakeVolume>(100, hashes.at(key.id)));
  };
  VolumeCache::Stored stored = [this](const std::string& id) -> std::optional<std::string> {
    const auto found = hashes.find(id);
    return silent ? std::nullopt
                  : std::optional(found == hashes.end() ? std::string() : found->second);
  };
  bool silent = false;
};

TEST(VolumeCache, NeverReturnsAReplacedVolume) {
  FakeStore store;
  VolumeCache cache(store.load, 1000, 1, store.stored);
  EXPECT_EQ((*wait_for(cache, "a"))->header().content_hash, "old");
  wait_for(cache, "a");
  EXPECT_EQ(cache.loads(), 1U);
  store.hashes["a"] = "new";
  EXPECT_EQ((*wait_for(cache, "a"))->header().content_hash, "new");
  EXPECT_EQ(cache.bytes(), 100U);
}

TEST(VolumeCache, TellsNewLabelsFromNewVoxels) {
  FakeStore store;
  VolumeCache cache(store.load, 1000, 1, store.stored);
  const auto held = wait_for(cache, "a");
  store.hashes["a"] = (*held)->header().content_hash + " labels";
  const auto outdated = cache.forget_outdated();
  ASSERT_EQ(ids_of(outdated), std::vector<std::string>{"a"});
  EXPECT_TRUE(outdated.front().only_labels);
  wait_for(cache, "b");
  store.hashes["b"] = "other labels";
  ASSERT_EQ(cache.forget_outdated().size(), 1U);
}

TEST(VolumeCache, ForgetsVolumesThatWereDeletedFromTheStore) {
  FakeStore store;
  VolumeCache cache(store.load, 1000, 1, store.stored);
  std::weak_ptr<const DeviceVolume> copy;
  {
    const auto held = wait_for(cache, "a");
    copy = *held;
    wait_for(cache, "b");
    EXPECT_TRUE(cache.forget_outdated().empty());
    store.hashes.erase("a");
    store.silent = true;
    EXPECT_TRUE(cache.forget_outdated().empty()) << "an unresponsive disk gives no information";
    store.silent = false;
    EXPECT_EQ(ids_of(cache.forget_outdated()), std::vector<std::string>{"a"});
    EXPECT_EQ(cache.loaded(), std::vector<std::string>{"b"});
    EXPECT_EQ(cache.bytes(), 100U);
    EXPECT_FALSE(copy.expired()) << "it still has a viewer";
  }
  EXPECT_TRUE(copy.expired());
  store.hashes["b"] = "anonymised";
  EXPECT_EQ(ids_of(cache.forget_outdated()), std::vector<std::string>{"b"});
  EXPECT_EQ(cache.bytes(), 0U);
}

TEST(VolumeCache, ForgetsUnreferencedVolumesOnRequest) {
  FakeStore store;
  VolumeCache cache(store.load, 1000, 1, store.stored);
  {
    const auto held = wait_for(cache, "a");
    wait_for(cache, "b");
    // The loading thread holds the volume for a moment after it has delivered it.
    while (cache.bytes() > 100) cache.forget_unused();
    EXPECT_EQ(cache.loaded(), std::vector<std::string>{"a"});
  }
  while (cache.bytes() > 0) cache.forget_unused();
  EXPECT_TRUE(cache.loaded().empty());
}

TEST(VolumeCache, KeepsAVolumeWithAndWithoutItsTable) {
  FakeStore store;
  VolumeCache cache(store.load, 1000, 1, store.stored);
  std::promise<Handle> with_table;
  cache.get({"a", true}, [&](Result<Handle> volume) { with_table.set_value(*volume); });
  EXPECT_NE(with_table.get_future().get(), *wait_for(cache, "a"));
  EXPECT_EQ(cache.loads(), 2U);
  EXPECT_EQ(cache.loaded(), std::vector<std::string>{"a"});
  store.hashes.erase("a");
  EXPECT_EQ(ids_of(cache.forget_outdated()), std::vector<std::string>{"a"});
  EXPECT_EQ(cache.bytes(), 0U);
}

Result<Handle> wait_for_copy(VolumeCache& cache, const VolumeKey& key) {
  std::promise<Result<Handle>> promise;
  cache.get(key, [&](Result<Handle> volume) { promise.set_value(std::move(volume)); });
  return promise.get_future().get();
}

TEST(VolumeCache, DropsTheLeastRecentlyShownPhaseIfNotAllFit) {
  VolumeCache cache(hundred_bytes, 300);
  EXPECT_TRUE(cache.fits("heart", 300));
  EXPECT_FALSE(cache.fits("heart", 301));
  for (const std::uint32_t phase : {0u, 1u, 2u})
    ASSERT_TRUE(wait_for_copy(cache, {"heart", false, phase}));
  EXPECT_TRUE(cache.find({"heart", false, 0})) << "shown again";
  ASSERT_TRUE(wait_for_copy(cache, {"heart", false, 3}));
  EXPECT_TRUE(cache.find({"heart", false, 0}));
  EXPECT_FALSE(cache.find({"heart", false, 1}));
  EXPECT_FALSE(cache.find({"heart", true, 0})) << "the copy with the table";
  EXPECT_EQ(cache.bytes(), 300U);
  EXPECT_EQ(cache.loaded().size(), 1U) << "phases are one volume";
}

TEST(VolumeCache, PhasesFitOnlyBesideOtherVolumesInUse) {
  VolumeCache cache(hundred_bytes, 300);
  const auto used = wait_for_copy(cache, {"other", false, 0});
  ASSERT_TRUE(wait_for_copy(cache, {"unused", false, 0}));
  ASSERT_TRUE(wait_for_copy(cache, {"heart", false, 0}));
  EXPECT_TRUE(cache.fits("heart", 200));
  EXPECT_FALSE(cache.fits("heart", 201));
}

}  // namespace
}  // namespace diaphane::render
