import { render } from "preact";
import "./style/all.css";
import { first_language, language, load_texts } from "./texts";
import { App } from "./views/app";
import { AppState } from "./views/state";
import "./views/theme";

const asked_again_after_ms = 2000;

async function load_first_texts(): Promise<void> {
  try {
    await load_texts(first_language());
  } catch {
    await new Promise((resolve) => setTimeout(resolve, asked_again_after_ms)); // there is no text yet to say it with
    await load_first_texts();
  }
}

const root = document.getElementById("app");
if (root) {
  const state = new AppState();
  void state.load();
  void load_first_texts().then(() => {
    language.subscribe((shown) => (document.documentElement.lang = shown));
    render(<App state={state} />, root);
  });
}
