#include "renderd/engine/cuda/kernel_cache.h"

#include <gtest/gtest.h>
#include <stdlib.h>

#include <filesystem>
#include <fstream>
#include <thread>

namespace diaphane::render::cuda {
namespace {

namespace fs = std::filesystem;

class KernelCacheTest : public ::testing::Test {
 protected:
  KernelCacheTest() {
    std::string pattern = (fs::temp_directory_path() / "kernel-cache-XXXXXX").string();
    directory_ = ::mkdtemp(pattern.data());
  }
  ~KernelCacheTest() override { fs::remove_all(directory_); }
  std::size_t files() const {
    return static_cast<std::size_t>(std::distance(fs::directory_iterator(directory_), {}));
  }
  fs::path only_file() const { return fs::directory_iterator(directory_)->path(); }

  std::string directory_;
};

const CompiledKernel kKernel{std::string("\x7f"
                                         "ELF\0code",
                                         9),
                             "_Z5traceILj3EEvv"};

TEST_F(KernelCacheTest, ReturnsStoredKernel) {
  const KernelCache cache(directory_);
  EXPECT_FALSE(cache.find("features 3"));
  cache.keep("features 3", kKernel);
  const auto found = KernelCache(directory_).find("features 3");
  ASSERT_TRUE(found);
  EXPECT_EQ(found->code, kKernel.code);
  EXPECT_EQ(found->symbol, kKernel.symbol);
  EXPECT_FALSE(cache.find("features 4"));
  EXPECT_EQ(files(), 1u) << "nothing temporary is left";
}

TEST_F(KernelCacheTest, IgnoresAndReplacesDamagedFile) {
  const KernelCache cache(directory_);
  cache.keep("key", kKernel);
  const fs::path path = only_file();
  const auto size = fs::file_size(path);
  std::string whole(size, '\0');
  std::ifstream(path, std::ios::binary).read(whole.data(), std::ssize(whole));
  for (std::size_t i = 0; i < size; ++i) {
    std::string damaged = whole;
    damaged[i] = static_cast<char>(damaged[i] ^ 0x10);
    std::ofstream(path, std::ios::binary) << damaged;
    ASSERT_FALSE(cache.find("key")) << "byte " << i;
    std::ofstream(path, std::ios::binary) << whole.substr(0, i);
    ASSERT_FALSE(cache.find("key")) << "cut after " << i;
  }
  cache.keep("key", kKernel);
  EXPECT_TRUE(cache.find("key"));
}

TEST_F(KernelCacheTest, RefusesFileOfAnotherKey) {
  const KernelCache cache(directory_);
  cache.keep("one", kKernel);
  const fs::path first = only_file();
  cache.keep("two", kKernel);
  for (const auto& entry : fs::directory_iterator(directory_)) {
    if (entry.path() != first)
      fs::copy_file(first, entry.path(), fs::copy_options::overwrite_existing);
  }
  EXPECT_TRUE(cache.find("one"));
  EXPECT_FALSE(cache.find("two"));
}

TEST_F(KernelCacheTest, RefusesCodeThatOthersCanChange) {
  const KernelCache cache(directory_);
  cache.keep("key", kKernel);
  const fs::path path = only_file();
  ASSERT_TRUE(cache.find("key"));
  fs::permissions(path, fs::perms::others_write, fs::perm_options::add);
  EXPECT_FALSE(cache.find("key"));
  fs::permissions(path, fs::perms::others_write, fs::perm_options::remove);
  ASSERT_TRUE(cache.find("key"));
  fs::rename(path, path.string() + ".moved");
  fs::create_symlink(path.string() + ".moved", path);
  EXPECT_FALSE(cache.find("key")) << "a link can lead to anyone's file";
}

TEST_F(KernelCacheTest, KeepsABoundedNumberOfFiles) {
  const KernelCache cache(directory_);
  for (std::size_t i = 0; i < KernelCache::kMostFiles + 10; ++i) {
    cache.keep(std::to_string(i), kKernel);
  }
  EXPECT_EQ(files(), KernelCache::kMostFiles);
}

TEST_F(KernelCacheTest, ConcurrentWritersLeaveACompleteFile) {
  {
    std::vector<std::jthread> threads;
    for (int i = 0; i < 4; ++i) {
      threads.emplace_back([this, i] {
        const KernelCache cache(directory_);
        // The code is large, so that concurrent writes to one file would be likely to mix.
        const CompiledKernel mine{std::string(100'000 * static_cast<std::size_t>(i + 1), 'a'), "s"};
        for (int j = 0; j < 20; ++j) {
          cache.keep("key", mine);
          ASSERT_TRUE(cache.find("key"));
        }
      });
    }
  }
  EXPECT_EQ(files(), 1u);
}

TEST(KernelCache, IsEmptyWithoutAWritableDirectory) {
  for (const char* directory : {"", "/proc/nowhere/kernels", "/dev/null/kernels"}) {
    const KernelCache cache(directory);
    cache.keep("key", kKernel);
    EXPECT_FALSE(cache.find("key")) << directory;
  }
}

}  // namespace
}  // namespace diaphane::render::cuda
