import { defineConfig } from "vite";
import { fakeServer } from "./server";

/** The page against a made-up server, to work on it without the programs. Never built, never shipped. */
export default defineConfig({ root: ".", plugins: [fakeServer()], server: { port: 5180, strictPort: true } });
