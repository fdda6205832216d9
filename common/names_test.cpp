#include "common/names.h"

#include <gtest/gtest.h>

namespace diaphane {
namespace {

TEST(Names, AcceptsPlainNamesInAnyScript) {
  for (const char* name : {"", "Ann", "J\u00f6rg M\u00fcller-Lang", "J. R. Smith", "Dr. O'Neill",
                           "Zo\u00eb D\u2019Arcy", "\u674e\u5c0f\u9f8d", "\u0410\u043d\u043d\u0430",
                           "\u0645\u0631\u064a\u0645", "Louis 14", "\u0928\u0947\u0939\u093e"}) {
    EXPECT_TRUE(is_plain_name(name)) << name;
  }
}

TEST(Names, RefusesNamesThatLookLikeLinksAddressesOrSentences) {
  for (const char* name : {"Your account ends. Go: http://evil.ex/x",
                           "evil.example",
                           "www.evil.example x",
                           "me@b.c",
                           "a/b",
                           "a:b",
                           "a\"b",
                           "Hello! Click",
                           "Really?",
                           "\u201cDiaphane\u201d",
                           "<b>",
                           "a|b",
                           "evil\u3002example",
                           "evil\uff0eexample",
                           "evil\u2024example",
                           "http\uff1a\uff0f\uff0fx",
                           "Ann (support)",
                           "a_b",
                           "\U0001d40c\U0001d41a",
                           "\u2192 here",
                           "\xff"}) {
    EXPECT_FALSE(is_plain_name(name)) << name;
  }
}

TEST(Names, CleanNameRemovesInvisibleCharacters) {
  EXPECT_EQ(clean_name(" Ann\u202e \u200b B\u2066 ", 40), "Ann B");
  EXPECT_EQ(clean_name("abcdef", 3), "abc");
}

}  // namespace
}  // namespace diaphane
