#include "common/utf8.h"

#include <gtest/gtest.h>

namespace diaphane {
namespace {

TEST(Utf8, AcceptsValidUtf8) {
  for (const char* text : {"", "plain", "\xc3\xa9", "\xe2\x82\xac", "\xf0\x9f\x98\x80",
                           "\xf4\x8f\xbf\xbf", "\xee\x80\x80"}) {
    EXPECT_TRUE(is_utf8(text)) << text;
  }
  EXPECT_TRUE(is_utf8(std::string_view("a\0b", 3)));
}

TEST(Utf8, RefusesInvalidUtf8) {
  for (const char* text : {"\x80", "\xff", "\xc3", "a\xc3(", "\xc0\x80", "\xc1\xbf", "\xe0\x80\x80",
                           "\xed\xa0\x80", "\xed\xbf\xbf", "\xe2\x82", "\xf0\x80\x80\x80",
                           "\xf4\x90\x80\x80", "\xf8\x88\x80\x80\x80"}) {
    EXPECT_FALSE(is_utf8(text)) << text;
  }
}

}  // namespace
}  // namespace diaphane
