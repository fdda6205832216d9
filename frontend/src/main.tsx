import { render } from "preact";
import "./style/all.css";
import { firstLanguage, language, loadTexts } from "./texts";
import { App } from "./views/app";
import { AppState } from "./views/state";
import "./views/theme";

const askedAgainAfterMs = 2000;

async function loadFirstTexts(): Promise<void> {
  try {
    await loadTexts(firstLanguage());
  } catch {
    await new Promise((resolve) => setTimeout(resolve, askedAgainAfterMs)); // no texts are loaded yet to show a message
    await loadFirstTexts();
  }
}

const root = document.getElementById("app");
if (root) {
  const state = new AppState();
  void state.load();
  void loadFirstTexts().then(() => {
    language.subscribe((shown) => (document.documentElement.lang = shown));
    render(<App state={state} />, root);
  });
}
