import { defineConfig } from "vite";
import { fake_server } from "./server";

/** The page against a made-up server, to work on it without the programs. Never built, never shipped. */
export default defineConfig({ root: ".", plugins: [fake_server()], server: { port: 5180, strictPort: true } });
