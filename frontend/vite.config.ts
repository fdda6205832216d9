import { defineConfig } from "vite";

export default defineConfig({
  build: {
    outDir: "dist",
    emptyOutDir: true,
    target: "es2022",
    assetsInlineLimit: 0, // the edge's policy allows no data: address for scripts and styles
    reportCompressedSize: false,
  },
  worker: { format: "es" },
});
