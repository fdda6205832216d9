import js from "@eslint/js";
import reactHooks from "eslint-plugin-react-hooks";
import tseslint from "typescript-eslint";

export default tseslint.config(
  {
    ignores: [
      "dist",
      "node_modules",
      "src/protocol/gen",
      "eslint.config.js",
      "dev/protocol.mjs",
      "dev/judge_folders.mjs",
    ],
  },
  js.configs.recommended,
  ...tseslint.configs.strictTypeChecked,
  ...tseslint.configs.stylisticTypeChecked,
  {
    plugins: { "react-hooks": reactHooks },
    languageOptions: { parserOptions: { projectService: true, tsconfigRootDir: import.meta.dirname } },
    rules: {
      "react-hooks/rules-of-hooks": "error",
      "react-hooks/exhaustive-deps": "error",
      // Properties are left out: those of the REST API and of stored values have other names.
      "@typescript-eslint/naming-convention": [
        "error",
        { selector: ["variable", "import"], format: ["camelCase", "PascalCase", "UPPER_CASE"] },
        { selector: "parameter", format: ["camelCase"], leadingUnderscore: "allow" },
        { selector: "function", format: ["camelCase", "PascalCase"] },
        { selector: ["classProperty", "memberLike"], modifiers: ["private"], format: ["camelCase"] },
        { selector: ["classMethod", "classicAccessor", "parameterProperty"], format: ["camelCase"] },
        { selector: "typeLike", format: ["PascalCase"] },
      ],
      "max-lines": ["error", { max: 500 }],
      "@typescript-eslint/restrict-template-expressions": ["error", { allowNumber: true, allowBoolean: true }],
      "@typescript-eslint/no-confusing-void-expression": ["error", { ignoreArrowShorthand: true }],
      "@typescript-eslint/no-misused-promises": ["error", { checksVoidReturn: { attributes: false } }],
      "no-restricted-syntax": [
        "error",
        { selector: "JSXAttribute[name.name='dangerouslySetInnerHTML']", message: "Text is text." },
      ],
    },
  },
  {
    // A new light shape must not fall into a default unseen.
    files: ["src/scene/*.ts"],
    rules: { "@typescript-eslint/switch-exhaustiveness-check": "error" },
  },
  {
    // No function is exempt. An exemption is a block of its own after this one, with its file and its reason.
    files: ["src/**/*.{ts,tsx}"],
    ignores: ["src/**/*.test.{ts,tsx}"],
    rules: {
      "max-lines-per-function": ["error", { max: 60, skipBlankLines: false, skipComments: true }],
    },
  },
);
