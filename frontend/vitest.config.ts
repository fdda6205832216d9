import { defineConfig } from "vitest/config";

export default defineConfig({
  test: {
    environment: "node",
    testTimeout: 60_000, // machines are busy, and no test is decided by time
    hookTimeout: 60_000,
    include: ["src/**/*.test.ts", "src/**/*.test.tsx"],
    reporters: ["default"],
    setupFiles: ["src/texts/testing.ts"],
  },
});
