// One script and one style sheet, put where the program takes them in at compile time.
import { defineConfig } from 'vite'

export default defineConfig({
  build: {
    outDir: '../src/report/bundle',
    emptyOutDir: true,
    target: 'es2022',
    cssCodeSplit: false,
    lib: { entry: 'src/main.ts', formats: ['es'], fileName: () => 'report.js', cssFileName: 'report' },
    rollupOptions: { output: { codeSplitting: false } },
    minify: true,
  },
})
