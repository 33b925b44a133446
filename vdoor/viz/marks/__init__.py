"""What is seen of each stage, whatever draws it: cells, dots, lines and charts."""
