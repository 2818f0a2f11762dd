"""Shows: the operator's web page. NiceGUI's own `ui` is imported as `nicegui_ui` everywhere."""
