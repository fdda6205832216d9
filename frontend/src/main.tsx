import { render } from "preact";
import "./style/all.css";
import { App } from "./views/app";
import { AppState } from "./views/state";
import "./views/theme";

const root = document.getElementById("app");
if (root) {
  const state = new AppState();
  render(<App state={state} />, root);
  void state.load();
}
